//! How much one request may cost, so that a mistyped number is refused before memory or time is spent.

use std::fmt;

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// How large the parts of a request may be.
///
/// The limits are far beyond what anybody was seen to need and far below what fills a machine. Where a
/// request is read (files, specs, settings) each part is compared with its limit before anything is
/// made of that size. A service that shares a machine sets lower ones, somebody with a large machine
/// higher ones. `docs/limits.md` has the table.
///
/// ```
/// use fd_core::{Limits, Resource};
///
/// let limits = Limits { samples: 5_000, ..Limits::default() };
/// assert!(limits.check(Resource::Samples, "the log", 5_000.0).is_ok());
/// let refused = limits.check(Resource::Samples, "the log", 5_001.0).map_err(|e| e.to_string());
/// let words = "the log: expected at most 5000 samples (limit `samples`), found 5001";
/// assert_eq!(refused, Err(words.to_owned()));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Limits {
    /// Samples of one log or run, on its even time base.
    pub samples: u64,
    /// Integration steps per sample.
    pub substeps: u64,
    /// Integration steps of one simulation of all logs of a diagnosis.
    pub steps: u64,
    /// Length of a delay, in integration steps.
    pub delay_steps: u64,
    /// Samples that a detector, a rule or a fit keeps or looks back at.
    pub window: u64,
    /// Orders, states, regions, functions: what a model to be learned is made of.
    pub order: u64,
    /// Corners of the filters of a threshold that follows the input.
    pub corners: u64,
    /// Random models, records and runs that something is calibrated on.
    pub models: u64,
    /// Engines of a benchmark, cases of a blind test.
    pub cases: u64,
    /// Threads.
    pub threads: u64,
    /// Any other whole number of a spec.
    pub count: u64,
    /// Bytes of a file of settings or of a model.
    pub bytes: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            samples: 10_000_000,
            substeps: 10_000,
            steps: 2_000_000,
            delay_steps: 1 << 20,
            window: 10_000,
            order: 100,
            corners: 100,
            models: 10_000,
            cases: 100_000,
            threads: 1_024,
            count: 1 << 53,
            bytes: 16 << 20,
        }
    }
}

/// What a limit is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Resource {
    /// [`Limits::samples`].
    Samples,
    /// [`Limits::substeps`].
    Substeps,
    /// [`Limits::steps`].
    Steps,
    /// [`Limits::delay_steps`].
    DelaySteps,
    /// [`Limits::window`].
    Window,
    /// [`Limits::order`].
    Order,
    /// [`Limits::corners`].
    Corners,
    /// [`Limits::models`].
    Models,
    /// [`Limits::cases`].
    Cases,
    /// [`Limits::threads`].
    Threads,
    /// [`Limits::count`].
    Count,
    /// [`Limits::bytes`].
    Bytes,
}

impl Resource {
    /// All of them, in the order of [`Limits`].
    pub const ALL: [Self; 12] = [
        Self::Samples,
        Self::Substeps,
        Self::Steps,
        Self::DelaySteps,
        Self::Window,
        Self::Order,
        Self::Corners,
        Self::Models,
        Self::Cases,
        Self::Threads,
        Self::Count,
        Self::Bytes,
    ];

    /// Name of the field of [`Limits`].
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Samples => "samples",
            Self::Substeps => "substeps",
            Self::Steps => "steps",
            Self::DelaySteps => "delay_steps",
            Self::Window => "window",
            Self::Order => "order",
            Self::Corners => "corners",
            Self::Models => "models",
            Self::Cases => "cases",
            Self::Threads => "threads",
            Self::Count => "count",
            Self::Bytes => "bytes",
        }
    }

    /// What is counted.
    fn unit(self) -> &'static str {
        match self {
            Self::Samples | Self::Window => " samples",
            Self::Substeps => " integration steps per sample",
            Self::Steps | Self::DelaySteps => " integration steps",
            Self::Threads => " threads",
            Self::Bytes => " bytes",
            Self::Order | Self::Corners | Self::Models | Self::Cases | Self::Count => "",
        }
    }
}

/// A part of a request is beyond its limit.
#[derive(Clone, Debug, PartialEq, Error)]
#[error(
    "{what}: expected at most {most}{} (limit `{}`), found {found}",
    resource.unit(), resource.name()
)]
pub struct LimitError {
    /// Which part: the path of a key, a file, a quantity.
    pub what: String,
    /// The limit.
    pub resource: Resource,
    /// Its value.
    pub most: u64,
    /// What was asked for.
    pub found: Amount,
}

/// A number as it was asked for: whole ones are shown whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Amount(pub f64);

impl fmt::Display for Amount {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.abs() < 1e15 { write!(f, "{}", self.0) } else { write!(f, "{:e}", self.0) }
    }
}

impl Limits {
    /// The value of a limit.
    #[must_use]
    pub fn most(&self, resource: Resource) -> u64 {
        match resource {
            Resource::Samples => self.samples,
            Resource::Substeps => self.substeps,
            Resource::Steps => self.steps,
            Resource::DelaySteps => self.delay_steps,
            Resource::Window => self.window,
            Resource::Order => self.order,
            Resource::Corners => self.corners,
            Resource::Models => self.models,
            Resource::Cases => self.cases,
            Resource::Threads => self.threads,
            Resource::Count => self.count,
            Resource::Bytes => self.bytes,
        }
    }

    /// Compares a part of a request with its limit; NaN is beyond every limit.
    ///
    /// # Errors
    ///
    /// Returns an error that names the part, the limit and both numbers.
    pub fn check(
        &self,
        resource: Resource,
        what: impl Into<String>,
        found: f64,
    ) -> Result<(), LimitError> {
        let most = self.most(resource);
        if found <= most as f64 {
            return Ok(());
        }
        Err(LimitError { what: what.into(), resource, most, found: Amount(found) })
    }
}
