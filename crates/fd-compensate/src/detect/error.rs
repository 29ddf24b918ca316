//! Why a detector cannot be built.

use fd_model::ModelError;
use thiserror::Error;

/// A detector cannot be built.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum DetectorError {
    /// A number is outside its range.
    #[error("{parameter} must be {expected}, got {found}")]
    Parameter {
        /// Name of the parameter.
        parameter: &'static str,
        /// Range it must lie in.
        expected: &'static str,
        /// Value given.
        found: f64,
    },
    /// A list has the wrong number of entries.
    #[error("{parameter} must have {expected} entries, got {found}")]
    Length {
        /// Name of the list.
        parameter: &'static str,
        /// Residual channels.
        expected: usize,
        /// Entries given.
        found: usize,
    },
    /// A channel never moves in the fault-free data, so nothing can be learned from it.
    #[error("residual channel {channel} is constant in {samples} fault-free samples")]
    ConstantChannel {
        /// Index of the channel.
        channel: usize,
        /// Samples looked at.
        samples: usize,
    },
    /// A channel is, to rounding, a combination of the channels before it.
    #[error("the covariance of the residual is singular at channel {channel}")]
    SingularCovariance {
        /// Index of the channel.
        channel: usize,
    },
    /// A model that the detector rests on has no answer.
    #[error(transparent)]
    Model(#[from] ModelError),
}

/// Refuses what is not a positive number.
pub(crate) fn positive(parameter: &'static str, found: f64) -> Result<(), DetectorError> {
    let expected = "positive and finite";
    let fine = found > 0.0 && found.is_finite();
    if fine { Ok(()) } else { Err(DetectorError::Parameter { parameter, expected, found }) }
}

/// Refuses what is not a finite number.
pub(crate) fn finite(parameter: &'static str, found: f64) -> Result<(), DetectorError> {
    let expected = "finite";
    let fine = found.is_finite();
    if fine { Ok(()) } else { Err(DetectorError::Parameter { parameter, expected, found }) }
}

/// Refuses a list of another length than there are channels.
pub(crate) fn length(
    parameter: &'static str,
    expected: usize,
    found: usize,
) -> Result<(), DetectorError> {
    if expected == found {
        Ok(())
    } else {
        Err(DetectorError::Length { parameter, expected, found })
    }
}
