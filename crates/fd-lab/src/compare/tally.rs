//! What one engine says of every entry, in numbers small enough to keep.

use serde::{Deserialize, Serialize};

use super::watch::Rest;

/// One engine of one scenario.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Unit {
    /// Index of the scenario.
    pub scenario: usize,
    /// Seed of the engine.
    pub seed: u64,
    /// One entry per generator, bias model and detector, the detector changing fastest.
    pub entries: Vec<Outcome>,
}

/// What an engine is for.
#[derive(Clone, Copy, Debug)]
pub(super) enum Role<'a> {
    /// It sets the thresholds.
    Thresholds,
    /// The results are taken from it; for each entry the factors on its threshold, one per rate of
    /// false alarms.
    Test(&'a [Vec<f64>]),
}

/// What one entry did on one engine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Outcome {
    /// Largest statistic over threshold of each fault-free run.
    Peaks(Vec<f64>),
    /// Alarms in the test runs.
    Alarms(Alarms),
    /// It cannot be built, or not on this engine.
    Failed(String),
}

/// Alarms of one entry in the test runs of one engine.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Alarms {
    /// Runs without an injected fault.
    pub healthy_runs: u64,
    /// Those with an alarm, one count per rate of false alarms.
    pub healthy: Vec<u64>,
    /// For each kind of fault and each size what was found at the wanted rate.
    pub faults: Vec<Vec<Found>>,
    /// Runs with a fault, of all kinds and sizes, that have no alarm without the fault, and those of
    /// them with an alarm, one pair per rate of false alarms.
    pub roc: Vec<(u64, u64)>,
    /// Found sensor faults by true sensor and named sensor.
    pub confusion: Vec<Vec<u64>>,
}

/// Runs with one fault.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Found {
    /// Runs that have no alarm without the fault.
    pub looked: u64,
    /// Delay of each alarm in samples.
    pub delays: Vec<u32>,
}

impl Alarms {
    /// Nothing seen yet.
    pub(super) fn none(sizes: &[usize], levels: usize, sensors: usize) -> Self {
        Self {
            healthy_runs: 0,
            healthy: vec![0; levels],
            faults: sizes.iter().map(|&count| vec![Found::default(); count]).collect(),
            roc: vec![(0, 0); levels],
            confusion: vec![vec![0; sensors]; sensors],
        }
    }

    /// Counts a run with a fault, by kind and size; says whether it is found at the wanted rate.
    /// `healthy` is the largest margin of the same run without the fault: where that raises an alarm,
    /// an alarm says nothing of the fault.
    pub(super) fn look(
        &mut self,
        (kind, size): (usize, usize),
        healthy: f64,
        rest: Rest,
        factors: &[f64],
    ) -> bool {
        for (sum, &factor) in self.roc.iter_mut().zip(factors) {
            if healthy <= factor {
                sum.0 += 1;
                sum.1 += u64::from(rest.peak > factor);
            }
        }
        if factors.first().is_none_or(|&wanted| healthy > wanted) {
            return false;
        }
        let of = &mut self.faults[kind][size];
        of.looked += 1;
        of.delays.extend(rest.alarm.map(|delay| u32::try_from(delay).unwrap_or(u32::MAX)));
        rest.alarm.is_some()
    }
}
