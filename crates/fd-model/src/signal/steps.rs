//! Constant, step, ramp, and the paper's step with sinusoids on top.

use serde::{Deserialize, Serialize};

use crate::{
    clock::reached,
    domain::SampleTime,
    signal::{
        check::{finite, in_range, times},
        error::SignalError,
        sine::MultiSine,
        sum::add,
    },
};

/// The same value at all times.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Constant {
    /// Value, in the unit of the channel.
    pub value: f64,
}

/// `initial` before `time_s`, `initial + amplitude` from then on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Step {
    /// Height of the step, in the unit of the channel.
    pub amplitude: f64,
    /// Time of the step, in seconds.
    #[serde(default)]
    pub time_s: f64,
    /// Value before the step, in the unit of the channel.
    #[serde(default)]
    pub initial: f64,
}

/// `initial` before `start_s`, then a straight line until `end_s`, then the value reached there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ramp {
    /// Slope, in the unit of the channel per second.
    pub slope_per_s: f64,
    /// Start of the rise, in seconds.
    #[serde(default)]
    pub start_s: f64,
    /// End of the rise, in seconds; without it the rise never ends.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end_s: Option<f64>,
    /// Value before the rise, in the unit of the channel.
    #[serde(default)]
    pub initial: f64,
}

/// A step plus a multi-frequency sinusoid: the input of section 4 of Patton & Chen (1992), whose
/// amplitudes and frequencies the paper does not print.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StepSines {
    /// The step.
    pub step: Step,
    /// The sinusoids, from `t = 0` on.
    pub sines: MultiSine,
}

impl Constant {
    /// A constant.
    ///
    /// ```
    /// # use fd_model::signal::Constant;
    /// assert_eq!(Constant::new(0.5).values(2)?, [0.5, 0.5]);
    /// # Ok::<(), fd_model::signal::SignalError>(())
    /// ```
    #[must_use]
    pub fn new(value: f64) -> Self {
        Self { value }
    }

    /// The first `n` samples.
    ///
    /// # Errors
    ///
    /// Returns an error when the value is not finite.
    pub fn values(&self, n: usize) -> Result<Vec<f64>, SignalError> {
        finite("constant", "value", self.value)?;
        Ok(vec![self.value; n])
    }
}

impl Step {
    /// A step of the given height from zero at `time_s`.
    ///
    /// ```
    /// # use fd_model::{SampleTime, signal::Step};
    /// // A step at 0.3 s is there at sample 3, though 3 · 0.1 is not 0.3 in floating point.
    /// assert_eq!(Step::new(1.0, 0.3).values(4, SampleTime::new(0.1)?)?, [0.0, 0.0, 0.0, 1.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn new(amplitude: f64, time_s: f64) -> Self {
        Self { amplitude, time_s, initial: 0.0 }
    }

    /// The first `n` samples.
    ///
    /// # Errors
    ///
    /// Returns the first parameter that is not finite.
    pub fn values(&self, n: usize, ts: SampleTime) -> Result<Vec<f64>, SignalError> {
        finite("step", "amplitude", self.amplitude)?;
        finite("step", "time_s", self.time_s)?;
        finite("step", "initial", self.initial)?;
        let after = self.initial + self.amplitude;
        Ok(times(n, ts)
            .map(|t| if reached(t, self.time_s, ts) { after } else { self.initial })
            .collect())
    }
}

impl Ramp {
    /// An endless ramp from zero.
    ///
    /// ```
    /// # use fd_model::{SampleTime, signal::Ramp};
    /// assert_eq!(Ramp::new(2.0, 1.0).values(4, SampleTime::new(1.0)?)?, [0.0, 0.0, 2.0, 4.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn new(slope_per_s: f64, start_s: f64) -> Self {
        Self { slope_per_s, start_s, end_s: None, initial: 0.0 }
    }

    /// The first `n` samples.
    ///
    /// # Errors
    ///
    /// Returns the first parameter that is not finite, or an end before the start.
    pub fn values(&self, n: usize, ts: SampleTime) -> Result<Vec<f64>, SignalError> {
        finite("ramp", "slope_per_s", self.slope_per_s)?;
        finite("ramp", "start_s", self.start_s)?;
        finite("ramp", "initial", self.initial)?;
        if let Some(end_s) = self.end_s {
            in_range("ramp", "end_s", "at or after `start_s`", end_s, self.start_s <= end_s)?;
        }
        let longest = self.end_s.map_or(f64::INFINITY, |end_s| end_s - self.start_s);
        Ok(times(n, ts)
            .map(|t| self.initial + self.slope_per_s * (t - self.start_s).clamp(0.0, longest))
            .collect())
    }
}

impl StepSines {
    /// A step with sinusoids on top.
    ///
    /// ```
    /// # use fd_model::{SampleTime, signal::{MultiSine, Phases, Step, StepSines}};
    /// let sines = MultiSine::new(vec![0.25], vec![0.1], Phases::Zero);
    /// let u = StepSines::new(Step::new(1.0, 0.0), sines).values(2, SampleTime::new(1.0)?)?;
    /// assert!((u[1] - 1.1).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn new(step: Step, sines: MultiSine) -> Self {
        Self { step, sines }
    }

    /// The first `n` samples.
    ///
    /// # Errors
    ///
    /// Returns what is wrong with the step or the sinusoids.
    pub fn values(&self, n: usize, ts: SampleTime) -> Result<Vec<f64>, SignalError> {
        Ok(add(self.step.values(n, ts)?, &self.sines.values(n, ts)?))
    }
}
