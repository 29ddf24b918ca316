//! What is wrong with an effect as text.

use fd_sim::equation::SyntaxError;
use thiserror::Error;

/// An effect of one's own cannot be used.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum TextError {
    /// An entry is not what it should be.
    #[error("effect `{label}`: {key}: expected {expected}, found {found}")]
    Value {
        /// Label of the effect.
        label: String,
        /// The entry.
        key: String,
        /// What it should be.
        expected: String,
        /// What it is.
        found: String,
    },
    /// A law is no expression.
    #[error("effect `{label}`: {key}: {error}")]
    Syntax {
        /// Label of the effect.
        label: String,
        /// The entry.
        key: String,
        /// What is wrong, and where.
        error: Box<SyntaxError>,
    },
}
