//! Identification of bias models: how the bias of a residual follows from the inputs.

mod error;

pub mod arx;
pub mod diagnostics;
pub mod least_squares;
pub mod order;
pub mod refine;
pub mod rls;

pub use crate::error::IdentError;
