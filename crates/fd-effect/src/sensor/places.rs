//! The laws of an effect at every output.

use fd_sim::{
    model::Model,
    scales::{ReplayScales, SignalScale},
};

use crate::{Effect, Offers, Reason, Sketch};

/// What the effects say when an output is constant.
pub(super) const STILL: Reason = Reason::Still("the output");

/// The laws of an effect at every output that moves, each as a sketch.
pub(super) fn each_output<'a>(
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
