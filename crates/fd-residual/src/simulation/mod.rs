//! Output-only residuals: measured minus simulated outputs.
//!
//! * **Equation.** `x_s(k+1) = f(x_s, u)`, `r(k) = y(k) − h(x_s, u)`; for a linear model
//!   `H_y = I` and `H_u = −G_u`, the simplest solution of eq. (5) of Patton and Chen (1992).
//! * **Source.** The "open-loop model" or "output error" generator, for example Chen and Patton
//!   (1999), Robust Model-Based Fault Diagnosis, section 2.4.
//! * **Assumptions.** The plant is stable, so that a wrong initial state is forgotten at the
//!   plant's own speed. The model may be nonlinear: [`Simulation`] runs any
//!   [`Plant`](fd_core::stage::Plant).
//! * **Do not use** for an unstable or integrating plant (the design refuses it), nor where
//!   unknown inputs or slow modes let the model drift away from the plant: take an
//!   [`observer`](crate::observer).

mod design;
mod run;

pub(crate) use self::design::check_stable;
pub use self::{design::SimulationDesign, run::Simulation};
