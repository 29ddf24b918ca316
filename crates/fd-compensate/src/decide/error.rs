//! Why a decision rule cannot be built.

use thiserror::Error;

/// A decision rule cannot be built.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum RuleError {
    /// A count is outside its range.
    #[error("{parameter} must be {expected}, got {found}")]
    Count {
        /// Name of the parameter.
        parameter: &'static str,
        /// Range it must lie in.
        expected: &'static str,
        /// Value given.
        found: u64,
    },
}
