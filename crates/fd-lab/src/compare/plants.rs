//! What a comparison asks of its plants, whatever they are.

use fd_model::{Discrete, Record, Scaling, StateSpace};
use fdiag::{
    spec::{NominalPlant, PipelineSpec},
    training::{Trained, TrainingError, train_on},
};

use super::{error::CompareError, fault::FaultKind};

/// The plants of a scenario.
pub(crate) trait Plants: Sync {
    /// The faults that are looked for.
    fn kinds(&self) -> &[FaultKind];

    /// Names of the outputs.
    fn outputs(&self) -> Vec<String>;

    /// All runs of one plant. The same seed gives the same runs whatever they are for.
    fn runs(&self, ask: Ask) -> Result<Runs, CompareError>;
}

/// Which runs are wanted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ask {
    /// Which plant.
    pub seed: u64,
    /// How many runs without an injected fault, for thresholds or, if `tested`, for results.
    pub fresh_runs: u64,
    /// Whether the results are taken from it, so that runs with faults are needed.
    pub tested: bool,
}

/// The runs of one plant.
pub(crate) struct Runs {
    /// The model that watches it.
    pub model: StateSpace<Discrete>,
    /// What its signals are in physical units.
    pub scaling: Scaling,
    /// The run that the bias is learned from.
    pub training: Record,
    /// Fault-free runs that scale the detectors.
    pub calibration: Vec<Record>,
    /// Runs without an injected fault that thresholds or results are taken from.
    pub healthy: Vec<Record>,
    /// The first of them with each kind of fault in each size; none for plants that set thresholds.
    pub faulty: Vec<Vec<Vec<Record>>>,
    /// Samples at the start of a run that no detector sees, as residual and simulated bias do not begin at rest there.
    pub unseen: usize,
}

impl Runs {
    /// A pipeline that has learned from these runs.
    pub(super) fn train(&self, spec: &PipelineSpec) -> Result<Trained, TrainingError> {
        let plant = NominalPlant::from(&self.model).in_units(self.scaling.clone());
        train_on(spec, plant, &self.training, &self.calibration)
    }
}
