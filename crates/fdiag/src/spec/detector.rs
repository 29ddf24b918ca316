//! Which detector, as a line of a spec.

use fd_compensate::{
    DrivenRows,
    calibrate::{CalibrationError, CalibrationPlan, FalseAlarms, calibrate},
    detect::{
        ChiSquare, Cusum, DEFAULT_MARGIN, DetectorError, Magnitude, NSigma, Spread, Standardizer,
    },
};
use fd_core::stage::Detector;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// A detector; its scales come from fault-free residuals, and its threshold from them or from a
/// stated rate of false alarms.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum DetectorSpec {
    /// The paper's rule: slightly above the largest fault-free magnitude.
    Maximum {
        /// How much above, relative to the maximum.
        #[serde(default = "default_margin")]
        margin: f64,
    },
    /// The largest channel in standard deviations from its fault-free mean.
    NSigma {
        /// Threshold in standard deviations, unless `false_alarms` is given.
        #[serde(default = "default_sigmas")]
        sigmas: f64,
        /// Rate of false alarms that the threshold is calibrated for.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        false_alarms: Option<FalseAlarms>,
    },
    /// The squared length of the residual in units of its fault-free covariance, summed over a
    /// window.
    ChiSquare {
        /// Samples in the window.
        #[serde(default = "default_window")]
        window: usize,
        /// Rate of false alarms that the threshold is calibrated for.
        false_alarms: FalseAlarms,
    },
    /// The two-sided cumulative sum of each channel: small, lasting changes.
    Cusum {
        /// Change in standard deviations, half of which is ignored: the reference value.
        #[serde(default = "default_reference")]
        reference: f64,
        /// Rate of false alarms that the threshold is calibrated for.
        false_alarms: FalseAlarms,
    },
}

/// A detector cannot be made from these fault-free residuals.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum DetectorSpecError {
    /// Its settings or its scales.
    #[error(transparent)]
    Detector(#[from] DetectorError),
    /// Its threshold.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
}

impl Default for DetectorSpec {
    fn default() -> Self {
        Self::Maximum { margin: DEFAULT_MARGIN }
    }
}

fn default_margin() -> f64 {
    DEFAULT_MARGIN
}

fn default_sigmas() -> f64 {
    3.0
}

fn default_window() -> usize {
    1
}

fn default_reference() -> f64 {
    0.5
}

/// The threshold of a detector that is about to be calibrated; any positive number will do.
const UNCALIBRATED: f64 = 1.0;

impl DetectorSpec {
    /// The detector for residuals like these.
    ///
    /// # Errors
    ///
    /// Returns an error when the fault-free residuals do not allow the scales or the threshold.
    pub fn calibrated(
        &self,
        healthy: DrivenRows<'_>,
        plan: &CalibrationPlan,
    ) -> Result<Box<dyn Detector>, DetectorSpecError> {
        let standard =
            || Standardizer::from_fault_free(healthy.residuals(), Spread::StandardDeviation);
        Ok(match *self {
            Self::Maximum { margin } => {
                Box::new(Magnitude::<f64>::above_fault_free_maximum(healthy.residuals(), margin)?)
            }
            Self::NSigma { sigmas, false_alarms: None } => {
                Box::new(NSigma::<f64>::new(standard()?, sigmas)?)
            }
            Self::NSigma { false_alarms: Some(wanted), .. } => {
                let mut detector = NSigma::<f64>::new(standard()?, UNCALIBRATED)?;
                let threshold = calibrate(&mut detector, healthy, wanted, plan)?.threshold;
                Box::new(detector.with_threshold(threshold)?)
            }
            Self::ChiSquare { window, false_alarms } => {
                let mut detector =
                    ChiSquare::<f64>::from_fault_free(healthy.residuals(), window, UNCALIBRATED)?;
                let threshold = calibrate(&mut detector, healthy, false_alarms, plan)?.threshold;
                Box::new(detector.with_threshold(threshold)?)
            }
            Self::Cusum { reference, false_alarms } => {
                let mut detector = Cusum::<f64>::new(standard()?, reference, UNCALIBRATED)?;
                let threshold = calibrate(&mut detector, healthy, false_alarms, plan)?.threshold;
                Box::new(detector.with_threshold(threshold)?)
            }
        })
    }
}
