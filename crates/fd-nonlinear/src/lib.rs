//! Residuals from nonlinear models.
//!
//! The generators of `fd-residual` are linear and designed for a model linearised at an operating point; away
//! from it the residual of a healthy plant is not zero. This crate uses the nonlinear model itself.
//!
//! | module | residual | when |
//! |---|---|---|
//! | [`extended`] | innovation of a Kalman filter linearised at the estimate | smooth models, little noise |
//! | [`unscented`] | the same with sigma points instead of slopes | curvature within the spread of the estimate |
//! | [`particle`] | the same with many sampled states | multimodal distributions, hard limits; few states |
//! | [`patched`] | measured minus simulated, slow parameters tracked | the cause of a bias is known |
//!
//! All of them run the state equations of [`StateEquations`], neither allocate nor fail per sample, and show
//! their memory in [`Stage::visit_state`](fd_core::stage::Stage::visit_state). The noise that a filter assumes
//! is described by a [`NoisyModel`].
//!
//! Where the model has no finite output (it left its region of validity) the residual is NaN, as the contract
//! of generators requires, and the filter restarts from its initial state.

mod array;
mod error;
pub mod extended;
mod gaussian;
mod linearise;
mod model;
mod noise;
pub mod particle;
pub mod patched;
mod scaled;
#[cfg(feature = "testing")]
pub mod testing;
pub mod unscented;

pub use self::{
    error::NonlinearError,
    linearise::{OperatingPoint, linearise},
    model::{PlantEquations, StateEquations},
    noise::{Noise, NoisyModel},
    scaled::ScaledEquations,
};
