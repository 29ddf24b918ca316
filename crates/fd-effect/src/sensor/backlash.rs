//! Play between the plant and its sensor.

use fd_sim::{model::Model, scales::ReplayScales};

use super::places::each_output;
use crate::{Effect, Offers};

/// Play of half width `w` between what moves and what is measured (a cable, a gear, a coupling), in
/// the middle when a run starts. The play operator is exact from step to step.
#[derive(Clone, Copy, Debug)]
pub struct SensorBacklash;

impl Effect for SensorBacklash {
    fn label(&self) -> &'static str {
        "sensor-backlash"
    }

    fn family(&self) -> &'static str {
        "sensor-nonlinearity"
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        each_output(self, nominal, scales, |sketch, output| {
            vec![
                sketch("play")
                    .strength("w", "backlash", &output.unit, output.std, [0.0, 1.5])
                    .memory("b", "played", &output.unit, "y")
                    .define("now", "shown", "clamp(b, y - w, y + w)")
                    .becomes("b", "now")
                    .wrap_output("now")
                    .starts([[0.03], [0.1], [0.3], [0.7]]),
            ]
        })
    }
}
