//! Every choice of a plant of one's own.

use std::{collections::BTreeMap, path::Path};

use fd_core::{LimitError, Limits, Resource};
use fd_model::{
    ModelError, RecordError,
    fault::FaultError,
    signal::{SignalError, SignalSpec},
};
use fd_sim::simulate::SimulateError;
use fdiag::{
    nonlinear::NonlinearError,
    spec::{GeneratorSpecError, ModelSource},
};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::compare::{
    config::CompareConfig,
    fault::{ProfileKind, Sizes},
};

/// A plant of one's own in place of the engine.
///
/// Sample time, settling time, lengths of runs, and start and rise of faults are those of the comparison; the
/// excitation of the engine is not used.
///
/// ```
/// let plant: fd_lab::compare::OwnPlant = toml::from_str(r#"
/// model = "tank.toml"
/// plant = "tank-with-leak.toml"
/// at = { q = 2.0 }
/// changes = { q = 0.5, h = 1.0, level = 1.0 }
/// signals.q = { kind = "staircase", low = 1.5, high = 2.5, hold_min_s = 60.0, hold_max_s = 300.0, seed = 1 }
/// faults = [{ input = "leak", unit = "cm^2", sizes = { smallest = 1e-3, largest = 0.1, count = 8 } }]
/// "#)?;
/// assert_eq!(plant.faults[0].input, "leak");
/// # Ok::<(), toml::de::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OwnPlant {
    /// The model that watches; the linear generators have it linearised at rest.
    pub model: ModelSource,
    /// What stands for reality. Its outputs have the noise that the file states.
    pub plant: ModelSource,
    /// Inputs of the model about which it is linearised; its states are those that rest there, searched from their
    /// initial values.
    pub at: BTreeMap<String, f64>,
    /// An ordinary change of every state, input and output of the model: what counts as one.
    pub changes: BTreeMap<String, f64>,
    /// What drives the inputs of the plant, every run anew; the seeds tell signals apart. Inputs without a signal are zero.
    pub signals: BTreeMap<String, SignalSpec>,
    /// Time in s that a run has gone on before its record begins.
    #[serde(default)]
    pub before_s: f64,
    /// The faults to be found.
    pub faults: Vec<OwnFault>,
}

/// A fault of a plant of one's own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OwnFault {
    /// The input of the plant by which it enters.
    pub input: String,
    /// What it is called in reports; its input and how it develops unless said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Unit of its size.
    pub unit: String,
    /// The output of the model whose sensor it is, if it is one, for the share of right sensors.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensor: Option<String>,
    /// How it develops.
    #[serde(default = "abrupt")]
    pub profile: ProfileKind,
    /// How large it is; a published size is a range of one.
    pub sizes: Sizes,
}

fn abrupt() -> ProfileKind {
    ProfileKind::Abrupt
}

impl OwnPlant {
    /// Lets relative paths of files begin in a folder.
    pub fn begin_in(&mut self, folder: &Path) {
        self.model.begin_in(folder);
        self.plant.begin_in(folder);
    }

    /// Returns the first setting that cannot be, before anything of its size is made.
    pub(super) fn check(&self, config: &CompareConfig) -> Result<(), OwnError> {
        let wrong = |setting, expected: &str, found: String| {
            Err(OwnError::Setting { setting, expected: expected.to_owned(), found })
        };
        if self.faults.is_empty() {
            return wrong("faults", "at least one", "none".to_owned());
        }
        for OwnFault { sizes, .. } in &self.faults {
            if !sizes.are_possible() {
                return wrong("faults.sizes", Sizes::POSSIBLE, sizes.to_string());
            }
        }
        for (setting, seconds) in
            [("before_s", self.before_s), ("settle_s", config.settle_s.unwrap_or(0.0))]
        {
            if !(seconds >= 0.0 && seconds.is_finite()) {
                return wrong(setting, "finite and not negative", seconds.to_string());
            }
        }
        for (setting, seconds) in [
            ("training.duration_s", config.training.duration_s),
            ("fresh.duration_s", config.duration_s()),
        ] {
            if seconds.is_nan() || seconds < config.sample_time_s {
                return wrong(setting, "at least one sample", seconds.to_string());
            }
            let samples = (self.before_s + seconds) / config.sample_time_s;
            Limits::default().check(Resource::Samples, setting, samples)?;
        }
        Ok(())
    }
}

/// A plant of one's own cannot be set up or run.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum OwnError {
    /// A file.
    #[error(transparent)]
    File(#[from] GeneratorSpecError),
    /// A name that is not there, or a value that cannot be.
    #[error("{setting}: expected {expected}, found `{found}`")]
    Setting {
        /// Where it was used.
        setting: &'static str,
        /// What it may be.
        expected: String,
        /// The name or value.
        found: String,
    },
    /// Runs that are longer than a limit.
    #[error(transparent)]
    Limit(#[from] LimitError),
    /// A signal that has to have a value has none, or one that cannot be.
    #[error(
        "{setting}: expected a value above zero for each state, input and output of the model, found {found} for `{name}`"
    )]
    Missing {
        /// Which table.
        setting: &'static str,
        /// Of which signal.
        name: String,
        /// What was found.
        found: String,
    },
    /// The model does not rest anywhere near.
    #[error("at: the model finds no rest near its initial states with these inputs")]
    NoRest,
    /// The plant runs away.
    #[error("the plant runs away {seconds} s after the start of a run")]
    Diverged {
        /// Since when.
        seconds: f64,
    },
    /// A fault that was there before is for engines only.
    #[error(
        "present: expected none with a plant of one's own; give the plant a parameter or a signal instead"
    )]
    Present,
    /// A simulation.
    #[error(transparent)]
    Simulate(#[from] SimulateError),
    /// A linearisation.
    #[error(transparent)]
    Nonlinear(#[from] NonlinearError),
    /// A signal.
    #[error(transparent)]
    Signal(#[from] SignalError),
    /// A fault.
    #[error(transparent)]
    Fault(#[from] FaultError),
    /// A linear model or a sample time.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A record.
    #[error(transparent)]
    Record(#[from] RecordError),
}
