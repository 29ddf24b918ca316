//! Effects between the plant and the logged measurement.

mod backlash;
mod bias;
mod cross_talk;
mod delay;
mod drift;
mod hysteresis;
mod lag;
mod noise;
mod places;
mod saturation;
mod scale;

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
use super::Effect;

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
