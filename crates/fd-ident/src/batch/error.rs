//! Why estimators cannot stand side by side.

use thiserror::Error;

use crate::error::IdentError;

/// Estimators cannot be built, or do not belong to a block of samples.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum BatchError {
    /// A setting is out of range.
    #[error(transparent)]
    Design(#[from] IdentError),
    /// The number of parameters is not one that registers are laid out for.
    #[error("estimators side by side have 1 to {most} parameters, got {found}")]
    Parameters {
        /// Most parameters.
        most: usize,
        /// Number that was asked for.
        found: usize,
    },
    /// A difference equation looks back further than there is room for.
    #[error("estimators side by side remember at most {most} past values, the orders need {found}")]
    Past {
        /// Most values.
        most: usize,
        /// Number that the orders need.
        found: usize,
    },
    /// A kind of forgetting that needs a step of another shape.
    #[error(
        "estimators side by side forget by kind none, equation18, exponential or directional, \
         got {found}; use one estimator for each"
    )]
    Forgetting {
        /// Name of the kind.
        found: &'static str,
    },
    /// A block of samples was made for other estimators.
    #[error("the block has {found} {what}, the estimators have {expected}")]
    Block {
        /// What differs: `"columns"` or `"estimators"`.
        what: &'static str,
        /// Number of the estimators.
        expected: usize,
        /// Number of the block.
        found: usize,
    },
}
