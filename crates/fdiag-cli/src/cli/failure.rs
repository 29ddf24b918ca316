//! Why a command failed, and the exit code that says so.

use std::{fmt, path::PathBuf, process::ExitCode};

use fdiag::model::ShownMessage;

/// A failed command.
#[derive(Debug)]
pub(crate) enum Failure {
    /// An input file is missing or wrong.
    Input { file: Option<PathBuf>, reason: String },
    /// The data or the model do not allow what was asked.
    Analysis(String),
    /// A result could not be written.
    Output { file: PathBuf, reason: String },
}

impl Failure {
    pub(crate) fn input(file: impl Into<PathBuf>, reason: impl fmt::Display) -> Self {
        Self::Input { file: Some(file.into()), reason: reason.to_string() }
    }

    /// An input file is wrong, and the reason says which.
    pub(crate) fn of_input(reason: impl fmt::Display) -> Self {
        Self::Input { file: None, reason: reason.to_string() }
    }

    pub(crate) fn analysis(reason: impl fmt::Display) -> Self {
        Self::Analysis(reason.to_string())
    }

    pub(crate) fn output(file: impl Into<PathBuf>, reason: impl fmt::Display) -> Self {
        Self::Output { file: file.into(), reason: reason.to_string() }
    }

    /// The documented exit code.
    pub(crate) fn code(&self) -> ExitCode {
        match self {
            Self::Input { .. } => ExitCode::from(3),
            Self::Analysis(_) => ExitCode::from(4),
            Self::Output { .. } => ExitCode::from(5),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let message = match self {
            Self::Input { file: Some(file), reason } => format!("{}: {reason}", file.display()),
            Self::Input { file: None, reason } | Self::Analysis(reason) => reason.clone(),
            Self::Output { file, reason } => {
                format!("cannot write {}: {reason}", file.display())
            }
        };
        // Whatever was in a file or on the command line, a terminal shows it and does not obey it.
        write!(f, "{}", ShownMessage(&message))
    }
}
