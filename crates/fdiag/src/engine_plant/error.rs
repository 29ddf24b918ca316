//! Why the engine cannot be diagnosed.

use fd_gap::fit::FitError;
use fd_jetengine::EngineError;
use fd_model::{ModelError, signal::SignalError};
use fd_sim::{model, outside::OutsideError, simulate::SimulateError};
use thiserror::Error;

/// The engine cannot be set up, run or diagnosed.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum EnginePlantError {
    /// The engine cannot be trimmed or run.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// A linear model or record is not in order.
    #[error(transparent)]
    Linear(#[from] ModelError),
    /// The noise of a log cannot be made.
    #[error(transparent)]
    Noise(#[from] SignalError),
    /// A model with equations is not in order.
    #[error(transparent)]
    Model(#[from] model::ModelError),
    /// A simulator cannot be built.
    #[error(transparent)]
    Simulate(#[from] SimulateError),
    /// It cannot be started as a black box.
    #[error(transparent)]
    Outside(Box<OutsideError>),
    /// The diagnosis has failed.
    #[error(transparent)]
    Fit(#[from] FitError),
}

impl From<OutsideError> for EnginePlantError {
    fn from(error: OutsideError) -> Self {
        Self::Outside(Box::new(error))
    }
}
