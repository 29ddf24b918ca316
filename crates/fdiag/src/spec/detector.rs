//! Which detector, as a line of a spec.

use fd_compensate::{
    SampleRows,
    detect::{DEFAULT_MARGIN, DetectorError, Magnitude},
};
use fd_core::stage::Detector;
use serde::{Deserialize, Serialize};

/// A detector, calibrated on fault-free residuals.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum DetectorSpec {
    /// The paper's rule: slightly above the largest fault-free magnitude.
    Maximum {
        /// How much above, relative to the maximum.
        #[serde(default = "default_margin")]
        margin: f64,
    },
}

impl Default for DetectorSpec {
    fn default() -> Self {
        Self::Maximum { margin: DEFAULT_MARGIN }
    }
}

fn default_margin() -> f64 {
    DEFAULT_MARGIN
}

impl DetectorSpec {
    /// The detector for residuals like these.
    ///
    /// # Errors
    ///
    /// Returns an error when the fault-free residuals do not allow a threshold.
    pub fn calibrated(&self, healthy: SampleRows<'_>) -> Result<Box<dyn Detector>, DetectorError> {
        Ok(match *self {
            Self::Maximum { margin } => {
                Box::new(Magnitude::<f64>::above_fault_free_maximum(healthy, margin)?)
            }
        })
    }

    /// A detector that never alarms, for runs that are only looked at.
    ///
    /// # Errors
    ///
    /// Never fails for at least one channel.
    pub fn silent(&self, channels: usize) -> Result<Box<dyn Detector>, DetectorError> {
        Ok(Box::new(Magnitude::<f64>::new(&vec![1.0; channels], f64::MAX)?))
    }
}
