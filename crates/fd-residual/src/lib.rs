//! Residual generators, each of the one form `r = H_u u + H_y y` (Patton and Chen 1992, eq. 2).
//!
//! | Room | Residual | Choose it when |
//! |------|----------|----------------|
//! | [`simulation`] | `y − y_sim(u)` | the plant is stable and a model of any kind exists |
//! | [`observer`] | innovation of an observer | initial state and disturbances must be forgotten |
//! | [`parity`] | `W (Y − T U)` over a window | a dead-beat, design-by-rank answer is wanted |
//! | [`weighted`] | `W r` of any of these | channels are combined, scaled or filtered |
//! | [`bank`] | several of these side by side | faults are isolated by a set of residuals |
//! | [`form`] | any stable `H_u`, `H_y` | the generator was designed elsewhere |
//!
//! Each design exposes its [`ResidualForm`], which [`analysis`] turns into design-time answers:
//! which faults it detects, how far they stand above noise, which signature it has.

pub mod adaptive;
pub mod analysis;
pub mod bank;
pub mod decouple;
pub mod directional;
pub mod disturbance;
pub mod eigenstructure;
mod error;
pub mod estimation;
pub mod form;
mod kalman;
mod matrix;
pub mod observer;
pub mod optimal;
pub mod parity;
pub mod simulation;
pub mod structured;
pub mod unknown_input;
pub mod weighted;

pub use crate::{
    error::DesignError,
    form::{GeneratorDesign, ResidualForm},
};
