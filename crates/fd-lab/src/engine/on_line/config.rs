//! What is done on line.

use fd_compensate::{
    calibrate::{Beyond, CalibrationPlan, FalseAlarms},
    residual_compensation::{ChangePolicy, CompensationPlan, Convergence, PlantChange},
};
use fd_ident::rls::RlsDesign;
use fdiag::spec::{AdaptiveSpec, BoundSpec, DetectorSpec};
use serde::{Deserialize, Serialize};

/// What is done on line, in seconds of the run and sizes relative to the reading.
///
/// ```
/// use fd_lab::engine::{EngineConfig, OnLineConfig};
///
/// let mut config = EngineConfig::default();
/// assert!(config.on_line.run);
/// // Only the diagnosis that is fitted beforehand:
/// config.on_line = OnLineConfig { run: false, ..OnLineConfig::default() };
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OnLineConfig {
    /// Whether it is done at all.
    pub run: bool,
    /// Longest training: what has not opened by then counts as not opened.
    pub longest_s: f64,
    /// The estimator (eq. 18).
    pub learning: RlsDesign,
    /// When the switch opens, and what is watched after that; in place of that of the pipeline.
    pub compensation: CompensationPlan,
    /// What watches after the opening, in place of that of the pipeline. The default follows the input, and is set for
    /// an alarm with 5 % probability in the 240 s of `after_s`.
    pub detector: DetectorSpec,
    /// How its threshold is found, in place of that of the pipeline. Twenty runs cannot show so low a rate: the default
    /// extrapolates.
    pub calibration: CalibrationPlan,
    /// Faults of the first sensor that begin half way through the training, and in another run after the opening.
    pub faults: Vec<TrainingFault>,
    /// Healthy time between the opening and what comes then.
    pub lead_s: f64,
    /// How far the plant drifts: 1 makes it another engine, drawn as the first was.
    pub drift: f64,
    /// How long the drift takes.
    pub drift_s: f64,
    /// How long the run goes on after drift or fault have begun.
    pub after_s: f64,
}

/// A fault that is there while the bias is learned, and stays.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainingFault {
    /// Size relative to the reading.
    pub size: f64,
    /// Rise time in s; 0 is an abrupt fault.
    pub rise_s: f64,
}

impl Default for OnLineConfig {
    fn default() -> Self {
        let fault = |size, rise_s| TrainingFault { size, rise_s };
        Self {
            run: true,
            longest_s: 600.0,
            learning: RlsDesign::default(),
            compensation: CompensationPlan {
                // Noise of this size keeps parameters from standing still to a thousandth for long.
                convergence: Convergence { tolerance: 3e-3, ..Convergence::default() },
                // 400 samples are twenty seconds, two thirds of a fresh run.
                plant_change: PlantChange {
                    policy: ChangePolicy::Retrain,
                    ..PlantChange::default()
                },
                ..CompensationPlan::default()
            },
            detector: DetectorSpec::AdaptiveThreshold(AdaptiveSpec {
                bound: BoundSpec::default(),
                corners: 3,
                slowest_samples: 100.0,
                memory_samples: 20.0,
                void_margin: 0.1,
                false_alarms: FalseAlarms::PerRun { probability: 0.05, samples: 4800 },
            }),
            calibration: CalibrationPlan {
                beyond: Beyond::Extrapolate,
                ..CalibrationPlan::default()
            },
            faults: vec![fault(0.005, 10.0), fault(0.05, 0.0), fault(0.5, 0.0)],
            lead_s: 60.0,
            drift: 0.5,
            drift_s: 30.0,
            after_s: 240.0,
        }
    }
}
