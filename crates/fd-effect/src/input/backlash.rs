//! Backlash of an actuator.

use fd_sim::{model::Model, scales::ReplayScales};

use super::places::each_input;
use crate::{Effect, Offers};

/// Play of half width `w` between command and plant, at rest in the middle when a run starts. The
/// play operator is exact for any step.
#[derive(Clone, Copy, Debug)]
pub struct InputBacklash;

impl Effect for InputBacklash {
    fn label(&self) -> &'static str {
        "input-backlash"
    }

    fn family(&self) -> &'static str {
        "actuator-nonlinearity"
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        each_input(self, nominal, scales, |sketch, input| {
            vec![
                sketch("play")
                    .strength("w", "backlash", &input.unit, input.peak(), [0.0, 0.95])
                    .memory("b", "played", &input.unit, "u")
                    .becomes("b", "clamp(b, u - w, u + w)")
                    .wrap_input("clamp(b, u - w, u + w)")
                    .starts([[0.02], [0.08], [0.2], [0.45], [0.65], [0.85]]),
            ]
        })
    }
}
