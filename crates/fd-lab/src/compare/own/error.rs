//! Why a plant of one's own cannot be set up or run.

use fd_core::LimitError;
use fd_model::{ModelError, RecordError, fault::FaultError, signal::SignalError};
use fd_sim::simulate::SimulateError;
use fdiag::{nonlinear::NonlinearError, spec::GeneratorSpecError};
use thiserror::Error;

/// A plant of one's own cannot be set up or run.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum OwnError {
    /// A file.
    #[error(transparent)]
    File(#[from] GeneratorSpecError),
    /// A name that is not there, or a value that cannot be.
    #[error("{setting}: expected {expected}, found `{found}`")]
    Setting {
        /// Where it was used.
        setting: &'static str,
        /// What it may be.
        expected: String,
        /// The name or value.
        found: String,
    },
    /// Runs that are longer than a limit.
    #[error(transparent)]
    Limit(#[from] LimitError),
    /// A signal that has to have a value has none, or one that cannot be.
    #[error(
        "{setting}: expected a value above zero for each state, input and output of the model, found {found} for `{name}`"
    )]
    Missing {
        /// Which table.
        setting: &'static str,
        /// Of which signal.
        name: String,
        /// What was found.
        found: String,
    },
    /// The model does not rest anywhere near.
    #[error("at: the model finds no rest near its initial states with these inputs")]
    NoRest,
    /// The plant runs away.
    #[error("the plant runs away {seconds} s after the start of a run")]
    Diverged {
        /// Since when.
        seconds: f64,
    },
    /// A fault that was there before is for engines only.
    #[error(
        "present: expected none with a plant of one's own; give the plant a parameter or a signal instead"
    )]
    Present,
    /// A simulation.
    #[error(transparent)]
    Simulate(#[from] SimulateError),
    /// A linearisation.
    #[error(transparent)]
    Nonlinear(#[from] NonlinearError),
    /// A signal.
    #[error(transparent)]
    Signal(#[from] SignalError),
    /// A fault.
    #[error(transparent)]
    Fault(#[from] FaultError),
    /// A linear model or a sample time.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A record.
    #[error(transparent)]
    Record(#[from] RecordError),
}
