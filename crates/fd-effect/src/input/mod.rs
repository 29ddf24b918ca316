//! Effects between the logged command and the plant.

mod asymmetric_lag;
mod backlash;
mod cross_coupling;
mod dead_zone;
mod delay;
mod gain;
mod lag;
mod offset;
mod power;
mod quantisation;
mod rate_limit;
mod saturation;

use fd_sim::model::Model;
use fd_sim::scales::{ReplayScales, SignalScale};

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
use super::{Effect, Offers, Reason, Sketch, dynamics};

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

/// What the effects say when an input is constant.
const STILL: Reason = Reason::Still("the input");

/// The laws of an effect at every input that moves, each as a sketch.
fn each_input<'a>(
    effect: &'a dyn Effect,
    nominal: &'a Model,
    scales: &'a ReplayScales,
    laws: impl Fn(&dyn Fn(&'static str) -> Sketch<'a>, &SignalScale) -> Vec<Sketch<'a>>,
) -> Offers {
    let offers = scales.inputs.iter().enumerate().flat_map(|(i, input)| {
        // A column that parameters may follow.
        let is_used = dynamics::mentions(nominal, &nominal.inputs[i].name);
        let sketch = |law| {
            Sketch::of_input(effect, law, nominal, scales, i)
                .require(input.moves(), STILL)
                .require(is_used, Reason::Idle)
        };
        laws(&sketch, input)
    });
    offers.map(Sketch::finish).collect()
}

/// The laws of an effect at every input, and at every signal inside the model, that moves.
fn each_place<'a>(
    effect: &'a dyn Effect,
    nominal: &'a Model,
    scales: &'a ReplayScales,
    laws: impl Fn(&dyn Fn(&'static str) -> Sketch<'a>, &SignalScale) -> Vec<Sketch<'a>>,
) -> Offers {
    let inside = scales.signals.iter().enumerate().filter(|(_, signal)| signal.moves());
    let inside = inside.flat_map(|(i, signal)| {
        laws(&|law| Sketch::of_signal(effect, law, nominal, scales, i), signal)
    });
    let inside: Offers = inside.map(Sketch::finish).collect();
    let mut offers = each_input(effect, nominal, scales, laws);
    offers.extend(inside);
    offers
}
