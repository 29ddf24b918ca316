//! Continuous and discrete time as types, so that the two cannot be mixed up.

use faer::c64;

use crate::error::ModelError;

/// A time axis on which a linear model lives.
pub trait TimeDomain: Copy {
    /// Whether a mode with this eigenvalue dies out.
    fn decays(&self, eigenvalue: c64) -> bool;
}

/// Time in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Continuous;

/// Time in samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Discrete {
    /// Time between samples.
    pub ts: SampleTime,
}

/// A positive, finite time between samples, in seconds.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct SampleTime(f64);

impl TimeDomain for Continuous {
    fn decays(&self, eigenvalue: c64) -> bool {
        eigenvalue.re < 0.0
    }
}

impl TimeDomain for Discrete {
    fn decays(&self, eigenvalue: c64) -> bool {
        eigenvalue.norm() < 1.0
    }
}

impl SampleTime {
    /// Checks a sample time.
    ///
    /// # Errors
    ///
    /// Returns an error unless `0 < seconds < ∞`.
    pub fn new(seconds: f64) -> Result<Self, ModelError> {
        if 0.0 < seconds && seconds.is_finite() {
            Ok(Self(seconds))
        } else {
            Err(ModelError::SampleTime { seconds })
        }
    }

    /// Seconds between samples.
    #[must_use]
    pub fn seconds(self) -> f64 {
        self.0
    }
}
