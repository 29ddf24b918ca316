//! The laws of an effect at every input, and at every signal inside the model.

use fd_sim::{
    model::Model,
    scales::{ReplayScales, SignalScale},
};

use crate::{Effect, Offers, Reason, Sketch, dynamics};

/// What an input was before a run, where that is taken to begin from rest with the first command, as most simulations do. A
/// stretch of a run goes on from the command that it begins with. Within the first step the time is that of a stage.
pub(super) const FROM_REST: &str = "if(t > 1.5*dt, u, 0)";

/// A first value of more than this part of the largest is a command.
pub(super) const COMMAND: f64 = 0.01;

/// Whether a log begins with a command to a plant that would rest without any: what lies between them may have begun from rest
/// as well, or may have been given this command for long.
pub(super) fn may_be_from_rest(scales: &ReplayScales, input: &SignalScale) -> bool {
    scales.rests && COMMAND * input.peak() < input.first.abs()
}

/// What the effects say when an input is constant.
pub(super) const STILL: Reason = Reason::Still("the input");

/// Starts for strengths that differ between the two signs: with each size of them, larger for the one or for the other.
pub(super) fn either_way(sizes: impl IntoIterator<Item = f64>) -> Vec<[f64; 2]> {
    sizes.into_iter().flat_map(|size| [[size, 0.5], [size, -0.5]]).collect()
}

/// The laws of an effect at every input that moves, each as a sketch.
pub(super) fn each_input<'a>(
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
pub(super) fn each_place<'a>(
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
