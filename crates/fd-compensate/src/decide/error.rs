//! Why a decision rule cannot be built.

use thiserror::Error;

use crate::detect::DetectorError;

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
    /// A number is outside its range.
    #[error("{parameter} must be {expected}, got {found}")]
    Number {
        /// Name of the parameter.
        parameter: &'static str,
        /// Range it must lie in.
        expected: &'static str,
        /// Value given.
        found: f64,
    },
    /// The fault-free residual does not say what is normal.
    #[error(transparent)]
    FaultFree(#[from] DetectorError),
    /// A signature cannot be told from no fault, or does not belong to this residual.
    #[error(
        "signature of hypothesis {hypothesis} `{name}`: expected {residual_len} finite gains, not all \
         zero, got {found:?}"
    )]
    Signature {
        /// Index of the hypothesis.
        hypothesis: usize,
        /// Its name.
        name: String,
        /// Residual channels.
        residual_len: usize,
        /// Gains given.
        found: Vec<f64>,
    },
}
