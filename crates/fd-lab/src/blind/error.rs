//! What can stop a blind test.

use std::path::{Path, PathBuf};

use fd_core::LimitError;
use fd_gap::fit::FitError;
use fd_jetengine::EngineError;
use fd_log::LogError;
use fd_model::ModelError;
use fd_sim::{model::LoadError, simulate::SimulateError};
use thiserror::Error;

use crate::journal::JournalError;

/// A blind test cannot be made, run or scored.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BlindError {
    /// A model is not correct.
    #[error("{error}")]
    Model {
        /// What is wrong.
        error: Box<LoadError>,
    },
    /// A linear model cannot be made or reduced.
    #[error(transparent)]
    Linear(Box<ModelError>),
    /// The engine does not run.
    #[error(transparent)]
    Engine(Box<EngineError>),
    /// A model cannot be simulated.
    #[error(transparent)]
    Simulate(Box<SimulateError>),
    /// A black box cannot be started.
    #[error(transparent)]
    Outside(#[from] fd_sim::outside::OutsideError),
    /// A model cannot be fitted.
    #[error(transparent)]
    Fit(Box<FitError>),
    /// A log cannot be read or written.
    #[error(transparent)]
    Log(Box<LogError>),
    /// A file cannot be read or written.
    #[error("{}: {error}", file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// What the system says.
        error: std::io::Error,
    },
    /// Nobody waited any longer; answers that were finished are in the file of answers.
    #[error("stopped before all cases were diagnosed")]
    Stopped,
    /// The file of answers.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// A file is not what it should be.
    #[error("{}: {what}", file.display())]
    Content {
        /// The file.
        file: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// A case that cannot be judged.
    #[error("{case}: {error}")]
    Case {
        /// Name of the case.
        case: String,
        /// Why not.
        #[source]
        error: Box<BlindError>,
    },
    /// A sealed truth is not the one that was committed to.
    #[error("the truth of {case} does not match its commitment: it was changed, or it is another")]
    Broken {
        /// Name of the case.
        case: String,
    },
    /// The same directory for cases and truth.
    #[error("the truth must lie apart from the cases, not in {}", directory.display())]
    TruthBeside {
        /// The directory.
        directory: PathBuf,
    },
    /// There are results already.
    #[error("{} is there already; a blind test is made into a new directory", directory.display())]
    Exists {
        /// The directory.
        directory: PathBuf,
    },
    /// Nothing suits a plant.
    #[error("no case of kind `{kind}` could be drawn in {tries} tries")]
    NothingSuits {
        /// Kind of the case.
        kind: &'static str,
        /// How often it was tried.
        tries: usize,
    },
    /// What was ordered cannot be made.
    #[error("{what}: expected {expected}, found {found}")]
    Order {
        /// Which part of the order.
        what: &'static str,
        /// What it may be.
        expected: &'static str,
        /// What it is.
        found: usize,
    },
    /// A part of the order is beyond a limit.
    #[error(transparent)]
    Limit(#[from] LimitError),
    /// No random numbers from the system.
    #[error("the system gives no random numbers: {what}")]
    Entropy {
        /// What the system says.
        what: String,
    },
}

impl BlindError {
    pub(super) fn file(file: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let file = file.to_owned();
        move |error| Self::File { file, error }
    }

    pub(super) fn content(file: &Path, what: impl std::fmt::Display) -> Self {
        Self::Content { file: file.to_owned(), what: what.to_string() }
    }
}

impl From<ModelError> for BlindError {
    fn from(error: ModelError) -> Self {
        Self::Linear(Box::new(error))
    }
}

impl From<EngineError> for BlindError {
    fn from(error: EngineError) -> Self {
        Self::Engine(Box::new(error))
    }
}

impl From<SimulateError> for BlindError {
    fn from(error: SimulateError) -> Self {
        Self::Simulate(Box::new(error))
    }
}

impl From<FitError> for BlindError {
    fn from(error: FitError) -> Self {
        Self::Fit(Box::new(error))
    }
}

impl From<LogError> for BlindError {
    fn from(error: LogError) -> Self {
        Self::Log(Box::new(error))
    }
}
