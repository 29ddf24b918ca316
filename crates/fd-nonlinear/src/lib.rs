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
//!
//! A pendulum that starts 2 rad away from where its filter believes it to be:
//!
//! ```
//! use fd_core::{Frame, stage::ResidualGenerator};
//! use fd_nonlinear::{Noise, NoisyModel, StateEquations, unscented::UnscentedDesign};
//! use fd_sim::{model::Model, simulate::StateMap};
//!
//! let model: Model = r#"
//! version = 1
//! kind = "equations"
//! name = "pendulum"
//! sample_time = 0.02
//! inputs = { u = { unit = "1/s^2" } }
//! outputs = { y = { unit = "rad", value = "q" } }
//! [states]
//! q = { unit = "rad", initial = 0.0, derivative = "w" }
//! w = { unit = "rad/s", initial = 0.0, derivative = "u - 9*sin(q) - 0.2*w" }
//! "#.parse()?;
//! let plant = StateMap::new(&model, &model.nominal(), model.sample_time()?)?;
//! let noise = Noise { process: vec![1e-4; 2], output: vec![1e-2], initial: vec![1.0; 2] };
//! let assumed = NoisyModel::new(plant.clone(), vec![0.0, 0.0], noise)?;
//! let mut filter = UnscentedDesign::new(assumed, None)?.freeze();
//!
//! let (mut x, mut next, mut residual) = ([2.0, 0.0], [0.0; 2], [0.0]);
//! let mut first = None;
//! for k in 0..500 {
//!     filter.step(Frame::new(filter.io(), k, &[0.0], &x[..1])?, &mut residual);
//!     first.get_or_insert(residual[0]);
//!     plant.clone().advance(k, &x, &[0.0], &[0.0], &mut next);
//!     x = next;
//! }
//! assert!(1.9 < first.unwrap_or(0.0) && residual[0].abs() < 1e-2);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

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
