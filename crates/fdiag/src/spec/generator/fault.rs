//! Where a fault enters the model, and which residual is to see it, as tables of a spec.

use fd_model::{Discrete, StateSpace};
use fd_residual::{
    DesignError,
    analysis::{Signature, UnknownInputs},
    structured::Structure,
};
use serde::{Deserialize, Serialize};

/// Where one fault enters, counted from 1: `{ sensor = 2 }`, `{ actuator = 1 }`, or
/// `{ direction = { states = […], outputs = […] } }`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum FaultEntry {
    /// Offset of an output.
    Sensor(usize),
    /// Offset of an input.
    Actuator(usize),
    /// Anything else, in the (scaled) units of the model.
    Direction {
        /// Entry into each state.
        states: Vec<f64>,
        /// Entry into each output.
        outputs: Vec<f64>,
    },
}

impl FaultEntry {
    /// All entries as unknown inputs of the model; an index of 0 is refused like one too large.
    ///
    /// # Errors
    ///
    /// Returns an error when the model has no such channel, or a direction has another length.
    pub fn unknown(
        entries: &[Self],
        model: &StateSpace<Discrete>,
    ) -> Result<UnknownInputs, DesignError> {
        // Channel 0 wraps to an index that no model has.
        entries.iter().enumerate().try_fold(UnknownInputs::none(model), |all, (i, entry)| {
            match entry {
                Self::Sensor(output) => all.sensor(model, output.wrapping_sub(1)),
                Self::Actuator(input) => all.actuator(model, input.wrapping_sub(1)),
                Self::Direction { states, outputs } => {
                    all.component(&format!("fault {}", i + 1), states, outputs)
                }
            }
        })
    }
}

/// Which residual is to react to which fault.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum SignatureSpec {
    /// Each residual reacts to one fault.
    Dedicated {},
    /// Each residual reacts to all faults but one.
    Generalised {},
    /// One row per residual, one character per fault: `"011"`.
    Rows {
        /// The rows.
        rows: Vec<String>,
    },
}

impl SignatureSpec {
    /// The structure; in a row, everything but `1` is a zero.
    #[must_use]
    pub fn structure(&self) -> Structure {
        match self {
            Self::Dedicated {} => Structure::Dedicated,
            Self::Generalised {} => Structure::Generalised,
            Self::Rows { rows } => {
                let bits = |row: &String| Signature(row.chars().map(|c| c == '1').collect());
                Structure::Rows(rows.iter().map(bits).collect())
            }
        }
    }
}
