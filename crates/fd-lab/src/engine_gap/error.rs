//! Why an engine cannot be diagnosed.

use fd_gap::fit::FitError;
use fd_sim::{outside::OutsideError, simulate::SimulateError};
use fdiag::{engine_plant::EnginePlantError, jetengine::EngineError};
use thiserror::Error;

/// An engine cannot be set up, run or diagnosed.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum EngineGapError {
    /// The engine cannot be trimmed or run.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// The noise of its outputs is not known.
    #[error(transparent)]
    Plant(#[from] EnginePlantError),
    /// A simulator cannot be built.
    #[error(transparent)]
    Simulate(#[from] SimulateError),
    /// It cannot be started as a black box.
    #[error(transparent)]
    Outside(#[from] OutsideError),
    /// The diagnosis has failed.
    #[error(transparent)]
    Fit(#[from] FitError),
}
