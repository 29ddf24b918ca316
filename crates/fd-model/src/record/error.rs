//! What can go wrong when records are joined, scaled or thinned.

use thiserror::Error;

use crate::unit::UnitError;

/// A record cannot be transformed as asked.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum RecordError {
    /// Two records do not have the same channels.
    #[error("{role} {index} is `{expected}` in the first record and `{found}` in the second")]
    Channel {
        /// `"input"` or `"output"`.
        role: &'static str,
        /// Index of the channel, from 0.
        index: usize,
        /// Channel of the first record, with unit; `"none"` when it has fewer.
        expected: String,
        /// Channel of the second record, with unit; `"none"` when it has fewer.
        found: String,
    },
    /// Two records do not have the same sample time.
    #[error("the first record has a sample time of {expected_s} s, the second of {found_s} s")]
    SampleTime {
        /// Sample time of the first record.
        expected_s: f64,
        /// Sample time of the second record.
        found_s: f64,
    },
    /// The second record does not begin on the time base of the first, after its end.
    #[error(
        "the second record begins at {found_s} s, expected {expected_s} s or whole samples later"
    )]
    Order {
        /// End of the first record.
        expected_s: f64,
        /// Start of the second record.
        found_s: f64,
    },
    /// There are more or fewer scales or units than channels.
    #[error("the record has {expected} {role}s, got {found} {what}s")]
    Count {
        /// `"input"` or `"output"`.
        role: &'static str,
        /// What was given, one per channel.
        what: &'static str,
        /// Number of channels.
        expected: usize,
        /// Number that was given.
        found: usize,
    },
    /// A scale is zero or not finite.
    #[error("the scale of {role} `{channel}` must be finite and not 0, got {value}")]
    Scale {
        /// `"input"` or `"output"`.
        role: &'static str,
        /// Name of the channel.
        channel: String,
        /// Scale that was given.
        value: f64,
    },
    /// Samples cannot be averaged over this number.
    #[error("a record can be thinned by 1, 2, …, got {factor}")]
    Factor {
        /// Number that was given.
        factor: usize,
    },
    /// A channel cannot be converted.
    #[error("{role} `{channel}`: {source}")]
    Unit {
        /// `"input"` or `"output"`.
        role: &'static str,
        /// Name of the channel.
        channel: String,
        /// Why not.
        source: UnitError,
    },
}
