//! What can stop a study of logs.

use std::path::PathBuf;

use fd_log::LogError;
use fd_model::{ModelError, RecordError, file::ModelFileError};
use fdiag::training::TrainingError;
use thiserror::Error;

/// Logs cannot be studied.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LogStudyError {
    /// The model file.
    #[error(transparent)]
    ModelFile(Box<ModelFileError>),
    /// A log file.
    #[error(transparent)]
    Log(Box<LogError>),
    /// A log does not fit the scaling of the model.
    #[error("{}: {source}", file.display())]
    Record {
        /// The log.
        file: PathBuf,
        /// Why.
        source: Box<RecordError>,
    },
    /// A log has no excitation, so that nothing can be learned from it.
    #[error("no input moves in the healthy logs, so the bias that it causes cannot be learned")]
    NoExcitation,
    /// The model cannot be sampled.
    #[error("model: {0}")]
    Model(#[from] ModelError),
    /// Training or diagnosis.
    #[error(transparent)]
    Training(#[from] TrainingError),
}

impl From<ModelFileError> for LogStudyError {
    fn from(error: ModelFileError) -> Self {
        Self::ModelFile(Box::new(error))
    }
}

impl From<LogError> for LogStudyError {
    fn from(error: LogError) -> Self {
        Self::Log(Box::new(error))
    }
}
