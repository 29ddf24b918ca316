//! From samples at any increasing times to a record on an even time base: what may be chosen, and what comes out of it.

use fd_core::{LimitError, Limits, memory::MemoryError};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

pub use self::series::TimeSeries;
use crate::error::ModelError;

mod grid;
mod series;

/// How a [`TimeSeries`] becomes even.
///
/// The grid begins at the first sample. On a grid time that meets a sample to within `tolerance`
/// the sample is taken as it is. Elsewhere inputs keep the value of the sample before
/// (zero-order hold; [`HeldInputs`] has other ways) and outputs are interpolated linearly between the samples before and
/// after; both are missing when those two are further apart than `max_gap_s`, and a value is
/// missing when one that it is made of is missing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ResamplePolicy {
    /// Step of the grid, in seconds. Without it, the mean step of an even series and the median
    /// step of any other.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sample_time: Option<f64>,
    /// Longest distance of samples that is bridged, in seconds; without it, five steps of the
    /// grid or five median steps, whichever is longer.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_gap_s: Option<f64>,
    /// Distance of a sample from a grid time, in steps, that counts as none.
    pub tolerance: f64,
    /// What happens to samples that are not later than the one before.
    pub disorder: Disorder,
    /// What becomes of inputs that change between two grid times. Without it, whoever simulates with them says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub held_inputs: Option<HeldInputs>,
    /// How long the record may become; not a matter of files.
    #[serde(skip)]
    pub limits: Limits,
}

/// What happens to samples that are not later than the one before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Disorder {
    /// They are an error.
    #[default]
    Reject,
    /// They are left out and counted in the [`TimeBaseReport`].
    Drop,
}

/// What becomes of inputs that change between two grid times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum HeldInputs {
    /// The grid time has the value of the sample before: what an input was then, if it was held.
    #[default]
    Latest,
    /// The grid time has the value on the line between the samples before and after, as outputs have: for inputs that were
    /// measured. Held, they would be late by half a step on average.
    Linear,
    /// Of inputs that were held, the grid time has the mean until the next one, so that a simulation that holds it has the same integral: with
    /// jitter nothing is late, and on a coarse grid nothing is skipped.
    Mean,
}

/// What the times of a [`TimeSeries`] were like.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TimeBaseReport {
    /// Samples of the series.
    pub rows: usize,
    /// Samples left out because their time was that of the sample before.
    pub duplicates: usize,
    /// Samples left out because their time was before that of the sample before.
    pub out_of_order: usize,
    /// Shortest step, in seconds.
    pub shortest_step_s: f64,
    /// Median step, in seconds.
    pub median_step_s: f64,
    /// Longest step, in seconds.
    pub longest_step_s: f64,
    /// Largest difference of a step from the median step, gaps aside, in seconds.
    pub jitter_s: f64,
    /// Steps that were too long to be bridged.
    pub gaps: Vec<Gap>,
    /// Whether every grid time met a sample, so that nothing was interpolated or missing.
    pub even: bool,
    /// Step of the grid, in seconds.
    pub step_s: f64,
    /// Samples on the grid.
    pub samples: usize,
}

/// A step that was too long to be bridged.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Gap {
    /// Time of the last sample before it, in seconds.
    pub from_s: f64,
    /// Time of the first sample after it, in seconds.
    pub to_s: f64,
}

/// A time series cannot be put on an even time base.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum TimeBaseError {
    /// A time is NaN or infinite.
    #[error("sample {index}: the time must be finite, got {time} s")]
    NonFinite {
        /// Index of the sample.
        index: usize,
        /// Its time, in seconds.
        time: f64,
    },
    /// A time is not after the one before.
    #[error("sample {index}: time must increase, got {time} s after {before} s")]
    NotIncreasing {
        /// Index of the sample.
        index: usize,
        /// Time of the sample before, in seconds.
        before: f64,
        /// Time of the sample, in seconds.
        time: f64,
    },
    /// One sample does not have a step.
    #[error("at least 2 samples are needed to find the sample time, got {samples}")]
    TooShort {
        /// Number of samples.
        samples: usize,
    },
    /// The grid would have more samples than the limit.
    #[error(
        "{limit}; {span_s} s in steps of {step_s} s, the longest without a sample {longest_s} s after \
         {longest_at_s} s"
    )]
    TooLong {
        /// Time from the first to the last sample, in seconds.
        span_s: f64,
        /// Step of the grid, in seconds.
        step_s: f64,
        /// Longest time between two samples, in seconds: a clock that jumped shows here.
        longest_s: f64,
        /// Time of the sample before it, in seconds.
        longest_at_s: f64,
        /// How many samples there may be.
        limit: LimitError,
    },
    /// A parameter of the policy is outside its range.
    #[error("resampling: `{parameter}` must be {expected}, got {value}")]
    Range {
        /// Field of the policy.
        parameter: &'static str,
        /// The range in words, with its unit.
        expected: &'static str,
        /// Value that was given.
        value: f64,
    },
    /// The even time base is more than there is memory for.
    #[error(transparent)]
    Memory(#[from] MemoryError),
    /// The values do not fit the channels, or the sample time is wrong.
    #[error(transparent)]
    Model(#[from] ModelError),
}

impl Default for ResamplePolicy {
    /// A step found from the data, gaps above five steps of the grid or the data, a tolerance of a thousandth of a step,
    /// and disorder rejected.
    fn default() -> Self {
        Self {
            sample_time: None,
            max_gap_s: None,
            tolerance: 1e-3,
            disorder: Disorder::Reject,
            held_inputs: None,
            limits: Limits::default(),
        }
    }
}

impl ResamplePolicy {
    pub(super) fn check(&self) -> Result<(), TimeBaseError> {
        let range = |parameter, expected, value: f64, inside| {
            let error = TimeBaseError::Range { parameter, expected, value };
            if inside && value.is_finite() { Ok(()) } else { Err(error) }
        };
        let inside = (0.0..0.5).contains(&self.tolerance);
        range("tolerance", "from 0 to below 0.5 steps", self.tolerance, inside)?;
        self.max_gap_s.map_or(Ok(()), |gap| range("max_gap_s", "above 0 s", gap, 0.0 < gap))?;
        self.sample_time.map_or(Ok(()), |ts| range("sample_time", "above 0 s", ts, 0.0 < ts))
    }
}

#[cfg(test)]
mod tests;
