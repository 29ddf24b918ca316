//! Why a command failed, and the exit code that says so.

use std::{
    fmt,
    path::PathBuf,
    process::{self, Termination},
};

use fdiag::model::ShownMessage;

/// How a command ends, as a number that also a host which goes on can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExitCode(pub u8);

impl ExitCode {
    /// It did what was asked.
    pub const SUCCESS: Self = Self(0);
}

impl Termination for ExitCode {
    fn report(self) -> process::ExitCode {
        process::ExitCode::from(self.0)
    }
}

/// A failed command.
#[derive(Debug)]
pub enum Failure {
    /// An input file is missing or wrong.
    Input {
        /// The file, unless the reason names it.
        file: Option<PathBuf>,
        /// What is wrong.
        reason: String,
    },
    /// The data or the model do not allow what was asked.
    Analysis(String),
    /// A result could not be written.
    Output {
        /// The file.
        file: PathBuf,
        /// What went wrong.
        reason: String,
    },
    /// What the command may take is used up: time or memory.
    Limit(String),
}

impl Failure {
    /// An input file is wrong.
    pub fn input(file: impl Into<PathBuf>, reason: impl fmt::Display) -> Self {
        Self::Input { file: Some(file.into()), reason: reason.to_string() }
    }

    /// An input file is wrong, and the reason says which.
    pub fn of_input(reason: impl fmt::Display) -> Self {
        Self::Input { file: None, reason: reason.to_string() }
    }

    /// The data or the model do not allow it.
    pub fn analysis(reason: impl fmt::Display) -> Self {
        Self::Analysis(reason.to_string())
    }

    /// A result could not be written.
    pub fn output(file: impl Into<PathBuf>, reason: impl fmt::Display) -> Self {
        Self::Output { file: file.into(), reason: reason.to_string() }
    }

    /// The documented exit code.
    #[must_use]
    pub fn code(&self) -> ExitCode {
        match self {
            Self::Input { .. } => ExitCode(3),
            Self::Analysis(_) => ExitCode(4),
            Self::Output { .. } => ExitCode(5),
            Self::Limit(_) => ExitCode(6),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let message = match self {
            Self::Input { file: Some(file), reason } => format!("{}: {reason}", file.display()),
            Self::Input { file: None, reason } | Self::Analysis(reason) | Self::Limit(reason) => {
                reason.clone()
            }
            Self::Output { file, reason } => {
                format!("cannot write {}: {reason}", file.display())
            }
        };
        // Whatever was in a file or on the command line, a terminal shows it and does not obey it.
        write!(f, "{}", ShownMessage(&message))
    }
}
