//! What can go wrong while normal behaviour is learned from data.

use fd_core::ShapeError;
use thiserror::Error;

/// The healthy logs do not allow the method, or a setting makes no sense.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum DataError {
    /// No log was given.
    #[error("expected at least one healthy log, found none")]
    NoLog,
    /// Logs have different channels.
    #[error("healthy log {log}: expected the channels of the first log, {expected}, found {found}")]
    Channels {
        /// Which log, from 1.
        log: usize,
        /// Inputs and outputs of the first log.
        expected: String,
        /// Inputs and outputs of this one.
        found: String,
    },
    /// Too few windows without a missing value.
    #[error(
        "{what}: expected at least {needed} complete windows in the healthy logs, found {found}"
    )]
    TooFew {
        /// What they are for.
        what: &'static str,
        /// How many are needed.
        needed: usize,
        /// How many there are.
        found: usize,
    },
    /// A channel that tells nothing.
    #[error(
        "channel `{channel}`: expected it to move in the healthy logs, found it constant; leave it out"
    )]
    Constant {
        /// Its name.
        channel: String,
    },
    /// The inputs do not move enough to tell the plant from its inputs.
    #[error(
        "the inputs do not excite windows of {window} samples: expected rank {expected}, found {found}; \
         move them more, or take a lower order"
    )]
    Excitation {
        /// Samples of the window.
        window: usize,
        /// Inputs of a window.
        expected: usize,
        /// Rank of the inputs in the logs.
        found: usize,
    },
    /// No relation between the samples of a window was found.
    #[error(
        "no parity relation of order {order}: {states} states leave none of {outputs} outputs of the window; \
         take a higher order"
    )]
    NoParity {
        /// Window length minus one.
        order: usize,
        /// States that were found or given.
        states: usize,
        /// Outputs of a window.
        outputs: usize,
    },
    /// A setting is out of its range.
    #[error("{setting}: expected {expected}, found {found}")]
    Setting {
        /// Name of the setting.
        setting: &'static str,
        /// What makes sense.
        expected: String,
        /// What was given.
        found: f64,
    },
    /// A factorisation did not converge, which finite data do not cause.
    #[error("{what} did not converge; look for values beyond all sense in the healthy logs")]
    NoConvergence {
        /// What was being computed.
        what: &'static str,
    },
    /// A matrix has the wrong size.
    #[error(transparent)]
    Shape(#[from] ShapeError),
}
