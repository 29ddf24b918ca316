//! What can be wrong with the description of a signal.

use thiserror::Error;

/// A signal cannot be evaluated as it is described.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SignalError {
    /// A parameter is NaN or infinite.
    #[error("{signal}: `{parameter}` must be finite, got {value}")]
    NotFinite {
        /// Kind of the signal.
        signal: &'static str,
        /// Field of the signal.
        parameter: &'static str,
        /// Value that was given.
        value: f64,
    },
    /// A parameter is outside its range.
    #[error("{signal}: `{parameter}` must be {expected}, got {value}")]
    Range {
        /// Kind of the signal.
        signal: &'static str,
        /// Field of the signal.
        parameter: &'static str,
        /// The range in words, with its unit.
        expected: &'static str,
        /// Value that was given.
        value: f64,
    },
    /// Two lists that belong together differ in length.
    #[error("{signal}: `{parameter}` needs {expected} values, one per frequency, got {found}")]
    Lengths {
        /// Kind of the signal.
        signal: &'static str,
        /// Field of the signal.
        parameter: &'static str,
        /// Number of frequencies.
        expected: usize,
        /// Number of values that were given.
        found: usize,
    },
    /// A frequency cannot be told from a lower one at this sample time.
    #[error(
        "{signal}: {frequency_hz} Hz is not below the Nyquist frequency {nyquist_hz} Hz of the sample time"
    )]
    Aliased {
        /// Kind of the signal.
        signal: &'static str,
        /// Frequency that was asked for.
        frequency_hz: f64,
        /// Half the sample rate.
        nyquist_hz: f64,
    },
    /// The shift register has no entry in the table of maximum-length taps.
    #[error("prbs: `bits` must be from {least} to {most}, got {found}")]
    Register {
        /// Shortest register.
        least: u32,
        /// Longest register.
        most: u32,
        /// Length that was given.
        found: u32,
    },
    /// The clock of a binary sequence does not fall on samples.
    #[error(
        "prbs: the clock period {clock_s} s must be a whole multiple of the sample time {ts_s} s"
    )]
    Clock {
        /// Clock period.
        clock_s: f64,
        /// Sample time.
        ts_s: f64,
    },
    /// The autoregression does not have a steady state.
    #[error(
        "ar-noise: the coefficients are not stable, reflection coefficient {order} is {value} and must be inside -1 to 1"
    )]
    UnstableNoise {
        /// Order of the reflection coefficient, from 1.
        order: usize,
        /// Its value.
        value: f64,
    },
}
