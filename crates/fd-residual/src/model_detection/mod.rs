//! Which of several models is this plant? A bank in which each residual is blind to its own model.
//!
//! * **Equation.** For models `y = G_u,j u + G_d,j d + G_w,j w`, `j = 1 … N`, residual `i` is `r_i = Q_i [y; u]` with
//!   `Q_i [G_u,i G_d,i; I 0] = 0`: zero when model `i` is the plant, whatever `u` and `d` are. If model `j` is the
//!   plant, `R_ij = Q_i [G_u,j G_d,j; I 0]` shows how far the two are apart, and the decision is for the model with the
//!   smallest residual. With noise, `Q_i` is whitened for that of model `i` (the approximate problem), and the gap of
//!   row `i` is `min_j ‖R_u,ij‖∞ / ‖R_w,ii‖∞`.
//! * **Distances** between models before any design: the ν-gap, which compares what the models do in closed loops and
//!   holds for unstable ones; the largest gain of the difference; its H2 norm; gains at given frequencies.
//! * **Source.** A. Varga, "Solving Fault Diagnosis Problems", Springer, 2017, chapters 4 and 6 (procedures EMD and
//!   AMD, examples 6.1 and 6.2). ν-gap: G. Vinnicombe, "Frequency domain uncertainty and the graph topology", IEEE TAC
//!   38(9), 1993; evaluation of residuals: K. S. Narendra and J. Balakrishnan, IEEE TAC 42(2), 1997.
//! * **Assumptions.** The plant is one of the models, or near one, and the input moves it: without input all linear
//!   models agree on `y = 0`.
//! * **Do not use** it for faults that are additive (offsets of sensors, leaks): a model with another gain is not one
//!   with an offset; take [`structured`](crate::structured). Nor for parameters that vary continuously: take
//!   [`adaptive`](crate::adaptive), or [`robust`](crate::robust) where they are only to be tolerated.

mod design;
mod distance;
mod models;
mod nu_gap;
mod run;

pub use self::{
    design::{DetectionRows, ModelDetection},
    distance::{ModelDistance, distances},
    models::PlantModel,
    nu_gap::nu_gap,
    run::{Memory, ModelDetector},
};
