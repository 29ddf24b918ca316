//! Faults: where they sit, what they do, and how their size develops over time.
//!
//! A [`FaultSpec`] is plain data that can stand in a TOML file:
//!
//! ```
//! use fd_model::fault::{FaultProfile, FaultSpec, Site};
//!
//! let spec: FaultSpec = toml::from_str(
//!     r#"
//!     site = { sensor = "T_7" }
//!     start_s = 10.0
//!     effect.add = { kind = "incipient", size = 0.05, rise_s = 30.0 }
//!     "#,
//! )?;
//! let same = FaultSpec::add(Site::sensor("T_7"), 10.0, FaultProfile::incipient(0.05, 30.0));
//! assert_eq!(spec, same);
//! # Ok::<(), toml::de::Error>(())
//! ```
//!
//! | Site | What happens |
//! |------|--------------|
//! | sensor | the recorded `y` differs from the plant's output |
//! | actuator | the `u` that the plant feels differs from the recorded `u` |
//! | component | a parameter of the plant moves, see [`Parameters`] |
//!
//! Sensor faults can be laid on any record ([`FaultSpec::apply_to_record`]); the other two need
//! the plant and act in a [`Simulation`](crate::Simulation).

use serde::{Deserialize, Serialize};

use crate::{clock::reached, domain::SampleTime, record::Record};

mod error;
mod profile;
mod site;

pub use self::{
    error::FaultError,
    profile::FaultProfile,
    site::{ChannelRef, Parameters, Site},
};

/// One fault: where, from when to when, and what it does.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FaultSpec {
    /// Where the fault sits.
    pub site: Site,
    /// Time at which it sets in, in seconds on the time axis of the record.
    #[serde(default)]
    pub start_s: f64,
    /// Time at which it is gone again, in seconds; without it the fault stays.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end_s: Option<f64>,
    /// What it does to the signal or parameter.
    pub effect: Effect,
}

/// What a fault does to a value `v` of its signal or parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Effect {
    /// `v + f(t)`; sizes in the unit of the channel.
    Add(FaultProfile),
    /// `v · (1 + f(t))`; sizes are pure numbers, so `0.02` is two per cent.
    Multiply(FaultProfile),
    /// `factor · v`.
    Scale(f64),
    /// The same value for ever, in the unit of the channel.
    StuckAt(f64),
    /// The last value before the fault set in, for ever.
    StuckLast,
}

impl FaultSpec {
    /// Any effect from `start_s` on.
    ///
    /// ```
    /// # use fd_model::fault::{Effect, FaultSpec, Site};
    /// let stuck = FaultSpec::new(Site::actuator("fuel"), 3.0, Effect::StuckLast);
    /// assert_eq!(stuck.end_s, None);
    /// ```
    #[must_use]
    pub fn new(site: Site, start_s: f64, effect: Effect) -> Self {
        Self { site, start_s, end_s: None, effect }
    }

    /// An additive fault from `start_s` on.
    ///
    /// ```
    /// # use fd_model::fault::{FaultProfile, FaultSpec, Site};
    /// let jump = FaultSpec::add(Site::sensor(0), 1.0, FaultProfile::abrupt(0.1));
    /// # assert_eq!(jump.start_s, 1.0);
    /// ```
    #[must_use]
    pub fn add(site: Site, start_s: f64, profile: FaultProfile) -> Self {
        Self::new(site, start_s, Effect::Add(profile))
    }

    /// A multiplicative fault from `start_s` on.
    ///
    /// ```
    /// # use fd_model::fault::{FaultProfile, FaultSpec, Site};
    /// let wear = FaultSpec::multiply(Site::component("eta_HPT"), 0.0, FaultProfile::drift(-1e-5));
    /// # assert_eq!(wear.start_s, 0.0);
    /// ```
    #[must_use]
    pub fn multiply(site: Site, start_s: f64, profile: FaultProfile) -> Self {
        Self::new(site, start_s, Effect::Multiply(profile))
    }

    /// Lays the fault on one signal over time; sample `k` is at `start + k·Ts`.
    ///
    /// Missing samples (NaN) stay missing.
    ///
    /// ```
    /// # use fd_model::{SampleTime, fault::{FaultProfile, FaultSpec, Site}};
    /// let fault = FaultSpec::add(Site::sensor(0), 0.2, FaultProfile::abrupt(1.0));
    /// let mut v = [5.0; 4];
    /// fault.apply(&mut v, 0.0, SampleTime::new(0.1)?)?;
    /// assert_eq!(v, [5.0, 5.0, 6.0, 6.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns the first parameter outside its range.
    pub fn apply(&self, values: &mut [f64], start: f64, ts: SampleTime) -> Result<(), FaultError> {
        let mut running = self.start(start, ts)?;
        for v in values {
            *v = running.next(*v);
        }
        Ok(())
    }

    /// Lays a sensor fault on the outputs of a record.
    ///
    /// # Errors
    ///
    /// Returns an error when the sensor is unknown, a parameter is outside its range, or the
    /// fault is not on a sensor.
    pub fn apply_to_record(&self, record: &mut Record) -> Result<(), FaultError> {
        if !matches!(self.site, Site::Sensor(_)) {
            let (site, name) = (self.site.kind(), self.site.target().to_string());
            return Err(FaultError::NeedsPlant { site, name });
        }
        let channel = self.site.channel_among(record.outputs())?;
        let mut running = self.start(record.time(0), record.ts())?;
        for k in 0..record.len() {
            let v = &mut record.y_mut(k)[channel];
            *v = running.next(*v);
        }
        Ok(())
    }

    /// The fault ready to run sample by sample from time `start` on.
    pub(crate) fn start(&self, start: f64, ts: SampleTime) -> Result<RunningFault, FaultError> {
        self.check()?;
        let shape = match &self.effect {
            Effect::Add(profile) | Effect::Multiply(profile) => Some(profile.start()),
            Effect::Scale(_) | Effect::StuckAt(_) | Effect::StuckLast => None,
        };
        let window = (self.start_s, self.end_s);
        Ok(RunningFault { effect: self.effect.clone(), window, shape, start, ts, k: 0, last: None })
    }

    fn check(&self) -> Result<(), FaultError> {
        let finite = |parameter, value: f64| {
            let error = FaultError::NotFinite { parameter, value };
            if value.is_finite() { Ok(()) } else { Err(error) }
        };
        finite("start_s", self.start_s)?;
        if let Some(end_s) = self.end_s {
            finite("end_s", end_s)?;
            if end_s < self.start_s {
                let expected = "at or after `start_s`";
                return Err(FaultError::Range { parameter: "end_s", expected, value: end_s });
            }
        }
        match &self.effect {
            Effect::Add(profile) | Effect::Multiply(profile) => profile.check(),
            Effect::Scale(factor) => finite("scale", *factor),
            Effect::StuckAt(value) => finite("stuck-at", *value),
            Effect::StuckLast => Ok(()),
        }
    }
}

/// A fault on its way through time.
#[derive(Debug)]
pub(crate) struct RunningFault {
    effect: Effect,
    window: (f64, Option<f64>),
    shape: Option<profile::RunningProfile>,
    start: f64,
    ts: SampleTime,
    k: usize,
    last: Option<f64>,
}

impl RunningFault {
    /// The next sample of the signal with the fault on it.
    pub(crate) fn next(&mut self, v: f64) -> f64 {
        let t = self.start + self.k as f64 * self.ts.seconds();
        self.k += 1;
        let (from, to) = self.window;
        let active = reached(t, from, self.ts) && !to.is_some_and(|to| reached(t, to, self.ts));
        if !active {
            if !v.is_nan() {
                self.last = Some(v);
            }
            return v;
        }
        let mut size = || self.shape.as_mut().map_or(0.0, |shape| shape.at(t - from, self.ts));
        match self.effect {
            Effect::Add(_) => v + size(),
            Effect::Multiply(_) => v * (1.0 + size()),
            Effect::Scale(factor) => factor * v,
            // A sample that was lost stays lost, whatever the sensor says.
            Effect::StuckAt(_) | Effect::StuckLast if v.is_nan() => v,
            Effect::StuckAt(value) => value,
            Effect::StuckLast => *self.last.get_or_insert(v),
        }
    }
}

#[cfg(test)]
mod tests;
