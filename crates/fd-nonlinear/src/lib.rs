//! Residuals from nonlinear models.
//!
//! The generators of `fd-residual` are linear, and what they are designed for is a model linearised at an
//! operating point; away from it the residual of a healthy plant is not zero. Here the model is taken as
//! it is.
//!
//! | module | residual | when |
//! |---|---|---|
//! | [`extended`] | innovation of a Kalman filter on slopes at the estimate | smooth models, little noise |
//! | [`unscented`] | the same with points in place of slopes | bends within the spread of the estimate |
//! | [`particle`] | the same with many drawn states | several humps, hard limits; few states |
//! | [`patched`] | measured minus simulated, slow parameters tracked | the cause of a bias is known |
//!
//! All of them run the state equations of [`StateEquations`], neither allocate nor fail per sample, and
//! show their memory in [`Stage::visit_state`](fd_core::stage::Stage::visit_state). What a filter expects
//! of the plant besides its equations is a [`NoisyModel`].
//!
//! A sample at which the model has no finite answer (it left its region of validity) has a residual of
//! NaN, as the contract of generators asks, and the filter starts anew from its initial state.

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
