//! Residual generators, each of the one form `r = H_u u + H_y y` (Patton and Chen 1992, eq. 2).
//!
//! | Room | Residual | Choose it when |
//! |------|----------|----------------|
//! | [`simulation`] | `y − y_sim(u)` | the plant is stable and a model of any kind exists |
//! | [`observer`] | innovation of an observer | initial state and disturbances must be forgotten |
//! | [`weighted`] | `W r` of any of these | channels are combined or scaled |
//! | [`form`] | any stable `H_u`, `H_y` | the generator was designed elsewhere |

mod error;
pub mod form;
mod matrix;
pub mod observer;
pub mod simulation;
pub mod weighted;

pub use crate::{
    error::DesignError,
    form::{GeneratorDesign, ResidualForm},
};
