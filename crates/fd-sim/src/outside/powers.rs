//! What an outside simulator can do.

use serde::{Deserialize, Serialize};

use super::error::{OutsideError, wrong};

/// What a simulator can do.
#[expect(clippy::struct_excessive_bools, reason = "each is a power of its own")]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Powers {
    /// It can be asked for one step after another.
    pub step: bool,
    /// It can begin another run after one; otherwise each run is made by a simulator that was started for it.
    pub resets: bool,
    /// It can be asked for a whole run in one call.
    pub rollout: bool,
    /// It can show the outputs of a sample without moving on.
    pub measure: bool,
    /// It shows its states, in the order of the initial ones.
    pub states: bool,
    /// Relative error of its outputs, if it knows: about 1e-16 for double, 1e-7 for single precision.
    pub precision: Option<f64>,
    /// The same run gives the same numbers.
    pub deterministic: bool,
    /// Runs that it makes, or steps, in one call.
    pub lanes: usize,
}

impl Default for Powers {
    /// One that steps, begins again, and does the same twice.
    fn default() -> Self {
        let (rollout, measure, states) = (false, false, false);
        let (precision, deterministic, lanes) = (None, true, 1);
        let (step, resets) = (true, true);
        Self { step, resets, rollout, measure, states, precision, deterministic, lanes }
    }
}

/// Most lanes that one call may be asked for.
const MOST_LANES: usize = 65_536;

impl Powers {
    /// Whether they make sense; `place` is who says it, for messages.
    pub(super) fn check(&self, place: &str) -> Result<(), OutsideError> {
        if !self.step && !self.rollout {
            return Err(wrong(place, "powers", "`step` or `rollout`", "neither"));
        }
        if let Some(precision) = self.precision.filter(|p| !(0.0..1.0).contains(p)) {
            let expected = "a relative error from 0 on and below 1";
            return Err(wrong(place, "powers.precision", expected, precision));
        }
        if !(1..=MOST_LANES).contains(&self.lanes) {
            let expected = format!("1 to {MOST_LANES} runs in one call");
            return Err(wrong(place, "powers.lanes", expected, self.lanes));
        }
        Ok(())
    }
}
