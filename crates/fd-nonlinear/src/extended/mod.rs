//! The extended Kalman filter: a Kalman filter on the model linearised at the estimate.
//!
//! * **Equations.** `x̂(k|k−1) = f(x̂(k−1), u(k−1))`, `r = y − h(x̂(k|k−1), u)`, and the covariance of a Kalman
//!   filter with `F = ∂f/∂x` at `x̂(k−1)` and `H = ∂h/∂x` at `x̂(k|k−1)` (Jazwinski 1970,
//!   theorem 8.1). On a linear model it is the Kalman filter.
//! * **Slopes** are central differences along the columns of the factor `S`, which is all that the update
//!   needs: `F S` and `H S`, with steps near the cube root of the rounding unit. The relative error is some
//!   `1e-10`; no Jacobian has to be written.
//! * **Slopes in turns.** With [`ExtendedDesign::linearised_over`] the slopes `F` are kept, and each sample renews a few
//!   of their columns, along the states: `1 + 2n/N` evaluations of the model per sample in place of `1 + 2n`, the same
//!   at each. Only the covariance is that of slopes up to `N` samples old, the estimate is propagated by the model.
//! * **Assumptions.** Noises white, normal, independent and small: within the spread of the estimate the model
//!   is nearly linear.
//! * **Do not use** it where the model bends or breaks within that spread (dead zones, stiction, several
//!   humps): it believes in a covariance that is too small, and lets go of the plant. See
//!   [`unscented`](crate::unscented) and [`particle`](crate::particle). The innovation follows a slow fault
//!   as that of every filter does: with little process noise it stays visible for longer.

mod design;
mod kept;
mod run;
mod slopes;

pub use self::{design::ExtendedDesign, run::ExtendedKalman};
