//! Why a compensator cannot be built.

use thiserror::Error;

/// A compensator cannot be built.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum CompensationError {
    /// Identifier, bias model and fit do not have the same sizes.
    #[error("{part} has {found} {quantity}, the bias model has {expected}")]
    Size {
        /// The part that does not fit.
        part: &'static str,
        /// What is counted.
        quantity: &'static str,
        /// Count of the bias model.
        expected: usize,
        /// Count of the part.
        found: usize,
    },
    /// A number of the plan is outside its range.
    #[error("{parameter} must be {expected}, got {found}")]
    Parameter {
        /// Name of the parameter, with its path in the plan.
        parameter: &'static str,
        /// Range it must lie in.
        expected: &'static str,
        /// Value given.
        found: f64,
    },
    /// A pre-fitted parameter or range is not finite.
    #[error("{quantity}[{index}] must be finite, got {found}")]
    NonFinite {
        /// Which list.
        quantity: &'static str,
        /// Index into it.
        index: usize,
        /// Value given.
        found: f64,
    },
}
