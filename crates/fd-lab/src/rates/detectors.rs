//! Every detector that states a rate.

use fd_compensate::{
    calibrate::FalseAlarms,
    detect::{
        glr::Course,
        sprt::{ErrorProbabilities, Sides},
        two_sample::SampleTest,
    },
};
use fdiag::spec::{AdaptiveSpec, BoundSpec, DetectorSpec};

/// A detector with a stated rate.
#[derive(Clone, Debug, PartialEq)]
pub struct Stated {
    /// A short name.
    pub name: &'static str,
    /// The detector.
    pub spec: DetectorSpec,
}

/// Every detector that can state that `probability` of the healthy runs of so many samples alarm, its other settings as
/// they come.
///
/// ```
/// assert_eq!(fd_lab::rates::detectors(0.05, 1000)[0].name, "n-sigma");
/// ```
#[must_use]
pub fn detectors(probability: f64, samples: usize) -> Vec<Stated> {
    let false_alarms = FalseAlarms::PerRun { probability, samples };
    let bound = AdaptiveSpec {
        bound: BoundSpec::Learned { quantile: 0.95 },
        corners: 4,
        slowest_samples: 100.0,
        memory_samples: 50.0,
        void_margin: 0.1,
        false_alarms,
    };
    let two_sample = |test| DetectorSpec::TwoSample { test, window: 50, false_alarms };
    let errors = ErrorProbabilities { false_alarm: 0.01, missed: 0.05 };
    let (shift, sides) = (1.0, Sides::Both);
    let stated = |name, spec| Stated { name, spec };
    vec![
        stated("n-sigma", DetectorSpec::NSigma { sigmas: 3.0, false_alarms: Some(false_alarms) }),
        stated("chi-square", DetectorSpec::ChiSquare { window: 1, false_alarms }),
        stated("chi-square of 20", DetectorSpec::ChiSquare { window: 20, false_alarms }),
        stated("cusum", DetectorSpec::Cusum { reference: 0.5, false_alarms }),
        stated(
            "sprt",
            DetectorSpec::Sprt { shift, errors, sides, false_alarms: Some(false_alarms) },
        ),
        stated(
            "glr",
            DetectorSpec::Glr {
                window: 50,
                courses: vec![Course::Step],
                whitening: 10,
                faults: None,
                false_alarms,
            },
        ),
        stated("two-sample, mean", two_sample(SampleTest::Mean)),
        stated("two-sample, variance", two_sample(SampleTest::Variance)),
        stated("two-sample, distribution", two_sample(SampleTest::Distribution)),
        stated("adaptive-threshold", DetectorSpec::AdaptiveThreshold(bound.clone())),
        stated("threshold-selector", DetectorSpec::ThresholdSelector(bound)),
    ]
}
