//! Effects between the logged command and the plant.

mod asymmetric_lag;
mod backlash;
mod cross_coupling;
mod dead_zone;
mod delay;
mod gain;
mod lag;
mod offset;
mod places;
mod power;
mod quantisation;
mod rate_limit;
mod saturation;

pub use self::{
    asymmetric_lag::InputAsymmetricLag, backlash::InputBacklash,
    cross_coupling::InputCrossCoupling, dead_zone::InputDeadZone, delay::InputDelay,
    gain::InputGain, lag::InputLag, offset::InputOffset, power::InputPower,
    quantisation::InputQuantisation, rate_limit::InputRateLimit, saturation::InputSaturation,
};
pub(super) use self::{
    delay::delays,
    lag::{LONGEST, STARTS},
};
use super::Effect;

/// All effects between the logged command and the plant.
///
/// ```
/// assert_eq!(fd_effect::input::all()[0].label(), "input-gain");
/// ```
#[must_use]
pub fn all() -> Vec<Box<dyn Effect>> {
    vec![
        Box::new(InputGain),
        Box::new(InputOffset),
        Box::new(InputDeadZone),
        Box::new(InputPower),
        Box::new(InputSaturation),
        Box::new(InputBacklash),
        Box::new(InputDelay),
        Box::new(InputLag),
        Box::new(InputAsymmetricLag),
        Box::new(InputRateLimit),
        Box::new(InputQuantisation),
        Box::new(InputCrossCoupling),
    ]
}
