//! What can stop a comparison.

use std::path::PathBuf;

use fd_core::LimitError;
use fd_report::PictureError;
use thiserror::Error;

use super::own::OwnError;
use crate::{engine::EngineStudyError, journal::JournalError};

/// A comparison cannot be set up, run or continued.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CompareError {
    /// The configuration is of another version.
    #[error("configuration has version {found}, this program reads version {expected}")]
    Version {
        /// Version that can be read.
        expected: u32,
        /// Version that was found.
        found: u32,
    },
    /// A setting cannot be.
    #[error("{setting}: expected {expected}, got {found}")]
    Setting {
        /// Name of the setting.
        setting: String,
        /// What it may be.
        expected: &'static str,
        /// What it is.
        found: String,
    },
    /// A setting is beyond a limit.
    #[error(transparent)]
    Limit(#[from] LimitError),
    /// The directory holds the beginning of another comparison.
    #[error(
        "{} was begun with another configuration; choose another directory or begin anew with \
         --restart", journal.display()
    )]
    OtherRun {
        /// The file of finished engines.
        journal: PathBuf,
    },
    /// A model file has changed since the engines in the directory were finished.
    #[error(
        "{} has changed since {} was begun; bring the file back, choose another directory or begin anew \
         with --restart", file.display(), journal.display()
    )]
    ChangedFile {
        /// The file of finished engines.
        journal: PathBuf,
        /// The model file.
        file: PathBuf,
    },
    /// A model file cannot be read.
    #[error("{}: {source}", file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// What the file system said.
        source: std::io::Error,
    },
    /// No engine of a scenario could be run.
    #[error("scenario `{scenario}`: {error}")]
    Scenario {
        /// Its name.
        scenario: String,
        /// Why.
        error: Box<EngineStudyError>,
    },
    /// A plant of one's own cannot be set up.
    #[error("scenario `{scenario}`: {error}")]
    Own {
        /// Its name.
        scenario: String,
        /// Why.
        error: Box<OwnError>,
    },
    /// An engine cannot be run.
    #[error(transparent)]
    Engine(#[from] EngineStudyError),
    /// A plant of one's own cannot be run.
    #[error(transparent)]
    Plant(#[from] OwnError),
    /// Nobody waited any longer; what was finished is in the journal.
    #[error("stopped before all engines were finished")]
    Stopped,
    /// The file of finished engines.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// A picture of the report.
    #[error(transparent)]
    Picture(#[from] PictureError),
}
