//! What can be wrong with a model file.

use std::{fmt, io};

use thiserror::Error;

use crate::{
    error::ModelError,
    shown::{Shown, ShownMessage},
};

/// What was tried with a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileAction {
    /// Reading.
    Read,
    /// Writing.
    Write,
}

impl fmt::Display for FileAction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Read => "read",
            Self::Write => "write",
        })
    }
}

/// A model file cannot be read or written. Lines and columns of the file count from 1, entries of
/// matrices from 0.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ModelFileError {
    /// The operating system refuses.
    #[error("{file}: cannot {action}: {kind}")]
    Io {
        /// Name of the file.
        file: String,
        /// What was tried.
        action: FileAction,
        /// Kind of the refusal.
        kind: io::ErrorKind,
    },
    /// The file is not TOML, or has wrong, unknown or missing keys.
    #[error("{file}, line {line}, column {column}: {}", ShownMessage(message))]
    Syntax {
        /// Name of the file.
        file: String,
        /// Line of the file.
        line: usize,
        /// Column of the line.
        column: usize,
        /// What is wrong there.
        message: String,
    },
    /// The file has another version of the format.
    #[error("{file}: expected `version = {expected}`, found {found}")]
    Version {
        /// Name of the file.
        file: String,
        /// Version that can be read.
        expected: u32,
        /// Version of the file.
        found: i64,
    },
    /// The file describes another kind of model.
    #[error("{file}: expected `kind = \"{expected}\"`, found `{}`", Shown(found))]
    Kind {
        /// Name of the file.
        file: String,
        /// Kind that can be read.
        expected: &'static str,
        /// Kind of the file.
        found: String,
    },
    /// A matrix has too many or too few rows.
    #[error("{file}, line {line}: `{key}` must have {expected} rows, one per {per}, found {found}")]
    Rows {
        /// Name of the file.
        file: String,
        /// Line at which the matrix begins.
        line: usize,
        /// Key of the matrix, such as `matrices.A`.
        key: &'static str,
        /// What there is one row for.
        per: &'static str,
        /// Rows that are needed.
        expected: usize,
        /// Rows there are.
        found: usize,
    },
    /// A row of a matrix is too long or too short.
    #[error(
        "{file}, line {line}: row {row} of `{key}` must have {expected} entries, one per {per}, found {found}"
    )]
    Columns {
        /// Name of the file.
        file: String,
        /// Line of the row.
        line: usize,
        /// Key of the matrix, such as `matrices.A`.
        key: &'static str,
        /// Row, from 0.
        row: usize,
        /// What there is one entry for.
        per: &'static str,
        /// Entries that are needed.
        expected: usize,
        /// Entries there are.
        found: usize,
    },
    /// An entry of a matrix is NaN or infinite.
    #[error("{file}, line {line}: `{key}[{row}][{column}]` must be finite, found {value}")]
    NonFinite {
        /// Name of the file.
        file: String,
        /// Line of the row.
        line: usize,
        /// Key of the matrix, such as `matrices.A`.
        key: &'static str,
        /// Row, from 0.
        row: usize,
        /// Column, from 0.
        column: usize,
        /// Value that was found.
        value: f64,
    },
    /// An operating point is not finite, or a scale is zero or not finite.
    #[error("{file}: `{key}` of {role} `{}` must be {expected}, found {found}", Shown(channel))]
    Channel {
        /// Name of the file.
        file: String,
        /// `"input"`, `"state"` or `"output"`.
        role: &'static str,
        /// Name of the channel.
        channel: String,
        /// `"operating_point"` or `"scale"`.
        key: &'static str,
        /// The range in words.
        expected: &'static str,
        /// Value that was found.
        found: f64,
    },
    /// A name or unit that a terminal or a page would not show as it is.
    #[error(
        "{file}: {what}: expected text without line breaks and control characters, found `{}`",
        Shown(found)
    )]
    NotPlain {
        /// Name of the file.
        file: String,
        /// Which text.
        what: &'static str,
        /// The text.
        found: String,
    },
    /// Two channels of one kind have the same name.
    #[error("{file}: two {role}s are called `{}`", Shown(channel))]
    DuplicateChannel {
        /// Name of the file.
        file: String,
        /// `"input"`, `"state"` or `"output"`.
        role: &'static str,
        /// The name.
        channel: String,
    },
    /// Numbers of channels do not fit the system.
    #[error("{file}: the model has {expected} {role}s, got {found} channels")]
    Count {
        /// Name of the file.
        file: String,
        /// `"input"`, `"state"` or `"output"`.
        role: &'static str,
        /// Number that the matrices have.
        expected: usize,
        /// Number of channels.
        found: usize,
    },
    /// The model is not stable and does not say that it need not be.
    #[error(
        "{file}: the model is not stable, there is an eigenvalue at {re} {im:+}i; if that is meant, set `allow_unstable = true`"
    )]
    Unstable {
        /// Name of the file.
        file: String,
        /// Real part of the worst eigenvalue (1/s, or per sample for discrete models).
        re: f64,
        /// Imaginary part.
        im: f64,
    },
    /// The model is wrong in another way.
    #[error("{file}: {source}")]
    Model {
        /// Name of the file.
        file: String,
        /// What is wrong.
        source: ModelError,
    },
}
