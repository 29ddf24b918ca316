//! Why a fleet cannot be built or fed.

use fd_core::ShapeError;
use fd_ident::{IdentError, batch::BatchError};
use fd_residual::DesignError;
use thiserror::Error;

/// A fleet cannot be built, or a block of samples is not one of its own.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum FleetError {
    /// The residual generator.
    #[error(transparent)]
    Generator(#[from] DesignError),
    /// A matrix of the generator.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// The bias model.
    #[error(transparent)]
    Bias(#[from] IdentError),
    /// Learning side by side.
    #[error(transparent)]
    Learning(#[from] BatchError),
    /// A detector or rule for other signals than the generator has.
    #[error("the {stage} expects {found} {signal} channels, the residual generator has {expected}")]
    Stage {
        /// Which of them.
        stage: &'static str,
        /// The signal.
        signal: &'static str,
        /// Channels of the generator.
        expected: usize,
        /// Channels that the stage expects.
        found: usize,
    },
    /// A setting out of its range.
    #[error("`{setting}` must be {expected}, found {found}")]
    Setting {
        /// Its name.
        setting: &'static str,
        /// The range.
        expected: &'static str,
        /// Its value.
        found: u64,
    },
    /// A block that was made for another fleet.
    #[error("a block of samples for {found} {what} was given to a fleet with {expected}")]
    Block {
        /// What does not fit.
        what: &'static str,
        /// What the fleet has.
        expected: usize,
        /// What the block has.
        found: usize,
    },
}
