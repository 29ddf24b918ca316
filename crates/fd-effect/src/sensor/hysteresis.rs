//! Hysteresis between the plant and its sensor.

use fd_sim::{model::Model, scales::ReplayScales};

use super::places::each_output;
use crate::{Effect, Offers};

/// Rate-independent memory between what moves and what is measured (a cable in its sheath, a bellows, a strain gauge): the
/// sensor shows `y - w z`, where `z` goes to the sign of the motion over a distance `L`, `dz/dy = (1 - z sgn y')/L` (Dahl).
/// Exact for what goes one way between the starts of two integration steps. A run starts in the middle.
///
/// *When not to use:* for play, which holds the reading where this one follows: [`SensorBacklash`](super::SensorBacklash).
#[derive(Clone, Copy, Debug)]
pub struct SensorHysteresis;

impl Effect for SensorHysteresis {
    fn label(&self) -> &'static str {
        "sensor-hysteresis"
    }

    fn family(&self) -> &'static str {
        "sensor-nonlinearity"
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        each_output(self, nominal, scales, |sketch, output| {
            vec![
                sketch("dahl")
                    .strength("w", "hysteresis", &output.unit, output.std, [0.0, 1.5])
                    .shape("L", "way", &output.unit, output.std, [0.01, 10.0], 1.0)
                    .memory("q", "before", &output.unit, "y")
                    .memory("z", "bend", "1", "0")
                    .abbreviate("s", "if(y < q, -1, 1)")
                    .define("now", "bent", "s + (z - s)*exp(-abs(y - q)/L)")
                    .becomes("q", "y")
                    .becomes("z", "now")
                    .wrap_output("y - w*now")
                    .starts([[0.05, 0.2], [0.2, 0.2], [0.2, 1.0]]),
            ]
        })
    }
}
