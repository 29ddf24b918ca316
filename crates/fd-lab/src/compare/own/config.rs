//! Every choice of a plant of one's own.

use std::{collections::BTreeMap, path::Path};

use fd_model::signal::SignalSpec;
use fdiag::spec::ModelSource;
use serde::{Deserialize, Serialize};

use crate::compare::fault::{ProfileKind, Sizes};

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
}
