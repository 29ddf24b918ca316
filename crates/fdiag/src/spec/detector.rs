//! Which detector, as a line of a spec.

use fd_compensate::{
    DrivenRows, SampleRows,
    calibrate::{FalseAlarms, calibrate_held_out},
    detect::{
        AdaptiveThreshold, ChiSquare, Cusum, DEFAULT_MARGIN, Glr, Magnitude, NSigma, Sprt,
        TwoSample,
        adaptive::Evaluation,
        glr::{Course, GlrDesign},
        sprt::{ErrorProbabilities, Sides},
        two_sample::SampleTest,
        whiten::WhitenerDesign,
    },
};
use fd_core::stage::Detector;
use serde::{Deserialize, Serialize};

use super::{
    adaptive::AdaptiveSpec,
    detector_data::{DetectorData, DetectorSpecError},
    signature::FaultSites,
};

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
    /// The largest channel against a given number, whatever the healthy residuals were: for residuals that come with
    /// bounds.
    Bound {
        /// The number, in the unit of the residual.
        #[serde(default = "default_bound")]
        threshold: f64,
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
    /// Wald's sequential probability ratio test of each channel.
    Sprt {
        /// Change to be found, in standard deviations.
        #[serde(default = "default_shift")]
        shift: f64,
        /// Wald's error probabilities of a single test; they set the boundaries, the upper one unless
        /// `false_alarms` is given.
        #[serde(default = "default_errors")]
        errors: ErrorProbabilities,
        /// Up and down, or up only.
        #[serde(default)]
        sides: Sides,
        /// Rate of false alarms that the upper boundary is calibrated for.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        false_alarms: Option<FalseAlarms>,
    },
    /// The generalised likelihood ratio: a change of unknown size at an unknown time.
    Glr {
        /// Onsets looked at, in samples back.
        #[serde(default = "default_onsets")]
        window: usize,
        /// How a fault may develop.
        #[serde(default = "default_courses")]
        courses: Vec<Course>,
        /// Most past samples that the whitening filter uses; 0 takes the residual as white in time.
        #[serde(default = "default_whitening")]
        whitening: usize,
        /// Faults whose signatures are looked for; none looks in all directions.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        faults: Option<FaultSites>,
        /// Rate of false alarms that the threshold is calibrated for.
        false_alarms: FalseAlarms,
    },
    /// The last samples of each channel against the fault-free ones.
    TwoSample {
        /// What is compared.
        test: SampleTest,
        /// Samples in the window.
        #[serde(default = "default_onsets")]
        window: usize,
        /// Rate of false alarms that the threshold is calibrated for.
        false_alarms: FalseAlarms,
    },
    /// The magnitude of each sample against a bound that follows the input.
    AdaptiveThreshold(AdaptiveSpec),
    /// The root mean square over a window against a bound that follows the input (Emami-Naeini et al.).
    ThresholdSelector(AdaptiveSpec),
}

/// Lines of specs, at least one of each kind.
#[cfg(feature = "testing")]
pub(super) const EVERY: [&str; 14] = [
    r#"kind = "maximum", margin = 0.1"#,
    r#"kind = "bound", threshold = 0.02"#,
    r#"kind = "n-sigma", false_alarms = { kind = "per-sample", rate = 2e-3 }"#,
    r#"kind = "chi-square", window = 5, false_alarms = { kind = "per-sample", rate = 2e-3 }"#,
    r#"kind = "cusum", reference = 1.0, false_alarms = { kind = "per-sample", rate = 2e-3 }"#,
    r#"kind = "sprt", shift = 2.0, false_alarms = { kind = "per-sample", rate = 2e-3 }"#,
    r#"kind = "sprt", sides = "upper", errors = { false_alarm = 1e-6, missed = 0.01 }"#,
    r#"kind = "glr", window = 20, courses = ["step", "ramp"], false_alarms = { kind = "per-sample", rate = 2e-3 }"#,
    r#"kind = "glr", window = 20, faults = "sensors", whitening = 4, false_alarms = { kind = "per-sample", rate = 2e-3 }"#,
    r#"kind = "two-sample", test = "mean", window = 20, false_alarms = { kind = "per-sample", rate = 2e-3 }"#,
    r#"kind = "two-sample", test = "distribution", window = 20, false_alarms = { kind = "per-sample", rate = 2e-3 }"#,
    r#"kind = "adaptive-threshold", corners = 3, slowest_samples = 20, memory_samples = 10, false_alarms = { kind = "per-sample", rate = 2e-3 }"#,
    r#"kind = "adaptive-threshold", bound = { kind = "ensemble", models = 8 }, memory_samples = 10, void_margin = 0.3, false_alarms = { kind = "per-sample", rate = 2e-3 }"#,
    r#"kind = "threshold-selector", bound = { kind = "learned", quantile = 0.9 }, corners = 3, slowest_samples = 20, memory_samples = 10, false_alarms = { kind = "per-sample", rate = 2e-3 }"#,
];

impl Default for DetectorSpec {
    fn default() -> Self {
        Self::Maximum { margin: DEFAULT_MARGIN }
    }
}

fn default_margin() -> f64 {
    DEFAULT_MARGIN
}

fn default_bound() -> f64 {
    1.0
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

fn default_shift() -> f64 {
    1.0
}

fn default_errors() -> ErrorProbabilities {
    ErrorProbabilities { false_alarm: 0.01, missed: 0.05 }
}

fn default_onsets() -> usize {
    50
}

fn default_courses() -> Vec<Course> {
    vec![Course::Step]
}

fn default_whitening() -> usize {
    10
}

/// The threshold of a detector that is about to be calibrated; any positive number will do.
const UNCALIBRATED: f64 = 1.0;

impl DetectorSpec {
    /// The kind, as a spec calls it.
    #[must_use]
    pub fn kind(&self) -> String {
        let table = toml::Table::try_from(self).ok();
        let kind = table.as_ref().and_then(|table| table.get("kind")?.as_str());
        kind.unwrap_or("detector").to_owned()
    }

    /// The detector for residuals like these.
    ///
    /// # Errors
    ///
    /// Returns an error when the fault-free residuals do not allow the scales or the threshold.
    pub fn calibrated(
        &self,
        data: &DetectorData<'_>,
    ) -> Result<Box<dyn Detector>, DetectorSpecError> {
        let residuals = data.healthy.residuals();
        match *self {
            Self::Maximum { margin } => {
                let rows = [Some(data.healthy), data.beginnings].into_iter().flatten();
                let all: Vec<f64> =
                    rows.flat_map(|rows| rows.residuals().iter().flatten()).copied().collect();
                let all = SampleRows::new(residuals.channels(), &all)?;
                Ok(Box::new(Magnitude::<f64>::above_fault_free_maximum(all, margin)?))
            }
            Self::Bound { threshold } => {
                let ones = vec![1.0; data.design.residual_len()];
                Ok(Box::new(Magnitude::<f64>::new(&ones, threshold)?))
            }
            Self::NSigma { sigmas, false_alarms: None } => {
                Ok(Box::new(NSigma::<f64>::new(data.standard()?, sigmas)?))
            }
            Self::NSigma { false_alarms: Some(wanted), .. } => {
                let detector = NSigma::<f64>::new(data.standard()?, UNCALIBRATED)?;
                data.calibrated(detector, wanted, NSigma::with_threshold)
            }
            Self::ChiSquare { window, false_alarms } => {
                let detector = ChiSquare::<f64>::from_fault_free(residuals, window, UNCALIBRATED)?;
                data.calibrated(detector, false_alarms, ChiSquare::with_threshold)
            }
            Self::Cusum { reference, false_alarms } => {
                let detector = Cusum::<f64>::new(data.standard()?, reference, UNCALIBRATED)?;
                data.calibrated(detector, false_alarms, Cusum::with_threshold)
            }
            Self::Sprt { shift, errors, sides, false_alarms } => {
                let detector = Sprt::<f64>::new(data.standard()?, shift, errors, sides)?;
                match false_alarms {
                    None => Ok(Box::new(detector)),
                    Some(wanted) => data.calibrated(detector, wanted, Sprt::with_threshold),
                }
            }
            Self::Glr { window, ref courses, whitening, faults, false_alarms } => {
                let whitener = WhitenerDesign::from_fault_free(residuals, whitening)?;
                let design = match faults {
                    None => GlrDesign::any_direction(whitener, courses, window)?,
                    Some(sites) => {
                        let signatures = sites.signatures(data.design)?;
                        GlrDesign::along(whitener, &signatures, courses, window)?
                    }
                };
                let detector = Glr::<f64>::new(&design, UNCALIBRATED)?;
                data.calibrated(detector, false_alarms, Glr::with_threshold)
            }
            Self::TwoSample { test, window, false_alarms } => {
                let detector = TwoSample::<f64>::new(test, residuals, window, UNCALIBRATED)?;
                data.calibrated(detector, false_alarms, TwoSample::with_threshold)
            }
            Self::AdaptiveThreshold(ref spec) => adaptive(data, spec, Evaluation::Magnitude),
            Self::ThresholdSelector(ref spec) => adaptive(data, spec, Evaluation::RootMeanSquare),
        }
    }
}

fn adaptive(
    data: &DetectorData<'_>,
    spec: &AdaptiveSpec,
    evaluation: Evaluation,
) -> Result<Box<dyn Detector>, DetectorSpecError> {
    let recipe = spec.recipe(data, evaluation)?;
    let learn = |healthy: DrivenRows<'_>| -> Result<_, DetectorSpecError> {
        Ok(AdaptiveThreshold::<f64>::new(&recipe.bound(healthy)?, evaluation, UNCALIBRATED)?)
    };
    let Some(plan) = data.plan else { return Ok(Box::new(learn(data.healthy)?)) };
    let (detector, found) = calibrate_held_out(data.healthy, spec.false_alarms, plan, learn)?;
    Ok(Box::new(detector.with_threshold(found.threshold)?))
}
