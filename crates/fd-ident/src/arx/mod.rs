//! Difference equations from the inputs to each residual channel (ARX models).
//!
//! Equation and order of parameters: [`ArxOrders`], after eq. (14) to (16) of Patton & Chen
//! (1992).
//!
//! | | type | numbers |
//! |---|---|---|
//! | fit to records | [`ArxFit`] → [`ArxEstimate`] | `f64`, faer |
//! | known model | [`ArxModel`] | `f64` |
//! | learn on line | [`RecursiveArx`] | any scalar |
//! | run | [`ArxSimulator`] | any scalar |
//!
//! Assumes a bias that is linear in the inputs around the operating point where it was learned.
//!
//! # When not to use it
//!
//! When no input excites the plant while it is healthy: nothing can then be learned. When the
//! poles are slow against the sample time and the residual is noisy: least squares then finds
//! poles that are too fast (see [`refine`](crate::refine)).

mod check;
mod estimate;
mod fit;
mod history;
mod model;
mod orders;
mod recursive;
mod regression;
mod replay;
mod response;
mod simulator;
mod stability;

pub(crate) use self::{
    check::{check_records, single_output},
    history::History,
    regression::{Regression, regressor},
    replay::held_inputs,
    stability::{reflect, roots},
};
pub use self::{
    estimate::{ArxDiagnosis, ArxEstimate},
    fit::ArxFit,
    model::ArxModel,
    orders::ArxOrders,
    recursive::RecursiveArx,
    replay::Start,
    simulator::ArxSimulator,
    stability::{MovedPole, Projection},
};
