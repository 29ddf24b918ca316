//! Effects between the plant and the logged measurement.

mod backlash;
mod bias;
mod cross_talk;
mod delay;
mod drift;
mod hysteresis;
mod lag;
mod noise;
mod saturation;
mod scale;

use fd_sim::model::Model;
use fd_sim::scales::{ReplayScales, SignalScale};

pub use self::{
    backlash::SensorBacklash,
    bias::SensorBias,
    cross_talk::SensorCrossTalk,
    delay::SensorDelay,
    drift::SensorDrift,
    hysteresis::SensorHysteresis,
    lag::SensorLag,
    noise::{SensorJitter, SensorNoise, SensorOutliers},
    saturation::SensorSaturation,
    scale::SensorScale,
};
use super::{Effect, Offers, Reason, Sketch};

/// All effects between the plant and the logged measurement.
///
/// ```
/// assert_eq!(fd_effect::sensor::all()[0].label(), "sensor-bias");
/// ```
#[must_use]
pub fn all() -> Vec<Box<dyn Effect>> {
    vec![
        Box::new(SensorBias),
        Box::new(SensorDrift),
        Box::new(SensorScale),
        Box::new(SensorLag),
        Box::new(SensorDelay),
        Box::new(SensorSaturation),
        Box::new(SensorBacklash),
        Box::new(SensorHysteresis),
        Box::new(SensorCrossTalk),
        Box::new(SensorOutliers),
        Box::new(SensorNoise),
        Box::new(SensorJitter),
    ]
}

/// What the effects say when an output is constant.
const STILL: Reason = Reason::Still("the output");

/// The laws of an effect at every output that moves, each as a sketch.
fn each_output<'a>(
    effect: &'a dyn Effect,
    nominal: &'a Model,
    scales: &'a ReplayScales,
    laws: impl Fn(&dyn Fn(&'static str) -> Sketch<'a>, &SignalScale) -> Vec<Sketch<'a>>,
) -> Offers {
    let offers = scales.outputs.iter().enumerate().flat_map(|(i, output)| {
        let sketch =
            |law| Sketch::of_output(effect, law, nominal, scales, i).require(output.moves(), STILL);
        laws(&sketch, output)
    });
    offers.map(Sketch::finish).collect()
}
