//! Which experiment would separate what is left.

use schemars::JsonSchema;
use serde::Serialize;

use crate::diagnose::{CauseId, PairId};

/// What can be done with the real system.
#[derive(Clone, Debug, PartialEq)]
pub struct Reach {
    /// Lowest and highest value of each input, in the order of the simulator; `None` keeps to the
    /// range of the logs, and lets an amplitude be doubled only within the saturations of the model.
    pub limits: Option<Vec<[f64; 2]>>,
    /// Longest experiment, in samples; the length of the longest log by default, at most 1000.
    pub samples: Option<usize>,
    /// Whether states that are not logged could be measured as well.
    pub can_measure: bool,
    /// Whether outputs could be sampled four times faster.
    pub can_sample_faster: bool,
    /// Seed of the excitations.
    pub seed: u64,
}

impl Default for Reach {
    fn default() -> Self {
        Self { limits: None, samples: None, can_measure: true, can_sample_faster: true, seed: 1 }
    }
}

/// What to do next.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Advice {
    /// What is to be told apart, the leader first. Empty when there is nothing to separate.
    pub between: Vec<Rival>,
    /// Their names, as `statement` has them.
    pub names: Vec<String>,
    /// Squares of the noise by which the present logs separate the leader from the nearest of the
    /// others.
    pub now: f64,
    /// Experiments that were simulated, in the order of effort: other inputs, then other sensors,
    /// then faster sampling; the most separating one first within each.
    pub tried: Vec<Separation>,
    /// Place in `tried` of the advised one: of least effort among those that separate all of them.
    pub best: Option<usize>,
    /// In words.
    pub statement: String,
}

/// An explanation that is to be told from others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(tag = "kind", content = "id", rename_all = "kebab-case")]
pub enum Rival {
    /// The model with refitted parameters.
    NoGap,
    /// A cause of the diagnosis.
    Cause(CauseId),
    /// A pair of the diagnosis.
    Pair(PairId),
}

/// How well an experiment separates causes.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Separation {
    /// The experiment.
    pub experiment: Experiment,
    /// For each rival of the leader: squares of the noise that remain when it is refitted to what
    /// the leader predicts, on the present logs and the new one together.
    pub distances: Vec<f64>,
}

impl Separation {
    /// The least of the distances.
    #[must_use]
    pub fn least(&self) -> f64 {
        self.distances.iter().copied().fold(f64::INFINITY, f64::min)
    }
}

/// An experiment.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Experiment {
    /// The kind of input.
    pub excitation: Excitation,
    /// Inputs, row by row, in the order of the simulator, on the time base of the logs; not serialised.
    #[serde(skip)]
    pub u: Vec<f64>,
    /// A state that is measured in addition.
    pub sensor: Option<Sensor>,
    /// How many times faster outputs are sampled; 1 or 4.
    pub faster: u32,
    /// In words.
    pub name: String,
}

/// A sensor of a state.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Sensor {
    /// Name of the state.
    pub state: String,
    /// Standard deviation of the noise that was assumed for it, in the unit of the state.
    pub noise: f64,
}

/// The kind of input of an experiment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Excitation {
    /// That of the longest log.
    Logged,
    /// The same, twice as far from where it begins, cut off at the limits.
    Larger,
    /// A binary sequence between the limits.
    Binary,
    /// Slow sinusoids.
    SlowSines,
    /// Fast sinusoids.
    FastSines,
    /// A sweep from slow to fast.
    Sweep,
    /// Random levels, held for random times.
    Staircase,
}
