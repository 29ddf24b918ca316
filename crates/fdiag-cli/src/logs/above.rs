//! What the paper's threshold, a little above the fault-free maximum, promises for fresh runs.

use fd_numeric::upper_median;
use fdiag::{spec::DetectorSpec, training::Trained};
use serde::{Deserialize, Serialize};

use super::material::Material;

/// Share of fresh healthy runs in alarm that needs no word.
const RARE: f64 = 0.05;

/// How many fresh healthy runs may exceed a maximum over the healthy logs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AboveMaximum {
    /// Samples that the maximum is over.
    pub samples: usize,
    /// Samples of a run.
    pub run: usize,
    /// The share of healthy runs that exceeds it at most. The largest of `samples + run` samples is as likely in any
    /// place, hence `run / (samples + run)`; the margin and the debouncing make it less.
    pub at_most: f64,
    /// Samples that would make it one run in twenty.
    pub needed: usize,
}

impl AboveMaximum {
    pub(super) fn of(material: &Material, trained: &Trained) -> Option<Self> {
        if !matches!(material.spec.detector, DetectorSpec::Maximum { .. }) {
            return None;
        }
        let later = material.logs.iter().any(|log| !log.healthy);
        let runs = material.logs.iter().filter(|log| log.healthy != later);
        let mut lengths: Vec<f64> = runs.map(|log| log.record.len() as f64).collect();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a length of a log"
        )]
        let run = upper_median(&mut lengths)?.round() as usize;
        let channels = trained.design().residual_len();
        let samples = trained.calibration().0.len() / channels.max(1);
        let at_most = run as f64 / (samples + run) as f64;
        let needed = run * 19;
        (at_most > RARE).then_some(Self { samples, run, at_most, needed })
    }

    /// As a sentence.
    pub(super) fn in_words(&self) -> String {
        let Self { samples, run, at_most, needed } = self;
        format!(
            "The threshold is the maximum over {samples} healthy samples and a margin: about {:.0} % of healthy runs of \
             {run} samples exceed it, more where the residual has a long memory. For one in twenty it takes {needed} \
             samples (with --healthy, {} times what was given: only a part of each log sets the threshold), or state the rate in the spec: `detector = {{ kind = \"chi-square\", false_alarms = {{ kind = \
             \"per-run\", probability = 0.05, samples = {run} }} }}` and `calibration.beyond = \"extrapolate\"`.",
            100.0 * at_most,
            needed.div_ceil((*samples).max(1)),
        )
    }
}
