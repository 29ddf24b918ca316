//! Why a threshold cannot be calibrated.

use thiserror::Error;

use crate::decide::RuleError;

/// Fewest expected independent exceedances that count as resolved: their number then scatters by less
/// than half of itself.
pub(super) const LEAST_EXCEEDANCES: f64 = 5.0;

/// A threshold cannot be calibrated.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum CalibrationError {
    /// The record has other channels than the detector.
    #[error("the fault-free record has {found} channels, the detector {expected}")]
    Channels {
        /// Channels of the detector.
        expected: usize,
        /// Channels of the record.
        found: usize,
    },
    /// The detector looks at other inputs than were recorded.
    #[error("the fault-free record has {found} inputs, the detector needs {expected}")]
    Inputs {
        /// Inputs of the detector.
        expected: usize,
        /// Inputs of the record.
        found: usize,
    },
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
    /// The raise condition is malformed.
    #[error(transparent)]
    Debouncing(#[from] RuleError),
    /// The record is short against its own memory, or not stationary.
    #[error(
        "{samples} fault-free samples are too few: {needed} are needed for blocks of {block} samples"
    )]
    TooShort {
        /// Samples of the record.
        samples: usize,
        /// Block length in samples.
        block: usize,
        /// Samples needed.
        needed: usize,
    },
    /// The autocorrelation does not decay within half of the record.
    #[error(
        "the fault-free record of {samples} samples does not forget itself: it drifts or is too short"
    )]
    Drift {
        /// Samples of the record.
        samples: usize,
    },
    /// The record holds too few independent stretches for the rate.
    #[error(
        "a false-alarm rate of {rate} cannot be promised from {found} independent stretches of fault-free \
         data; at least {needed} are needed"
    )]
    TooFewStretches {
        /// Rate wanted, per sample or per stretch.
        rate: f64,
        /// Stretches needed.
        needed: usize,
        /// Stretches found.
        found: usize,
    },
    /// The record holds too few independent exceedances for the rate.
    #[error(
        "the wanted rate means {expected_exceedances:.2} independent exceedances in {samples} fault-free samples, and at \
         least {LEAST_EXCEEDANCES} are needed: give {needed} samples, or say beyond = \"extrapolate\" under \
         [calibration]"
    )]
    Unresolved {
        /// Exceedances expected in the record.
        expected_exceedances: f64,
        /// Samples of the record, of the residual that is judged.
        samples: usize,
        /// Samples like these that would hold enough.
        needed: usize,
    },
}
