//! Offset of an actuator.

use fd_sim::{
    model::Model,
    scales::{ReplayScales, SignalScale},
};

use crate::{Effect, InAnotherRun, Offers, Reason, Sketch, dynamics::mentions};

/// Times of a step, as parts of the log, from which to start.
const ONSETS: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];

/// Offset `u + o`, all along or, `stepwise`, since some time. A constant input has one too.
#[derive(Clone, Copy, Debug)]
pub struct InputOffset;

impl Effect for InputOffset {
    fn label(&self) -> &'static str {
        "input-offset"
    }

    fn family(&self) -> &'static str {
        "actuator-offset"
    }

    fn is_signed(&self) -> bool {
        true
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        let inputs = scales.inputs.iter().enumerate().flat_map(|(i, input)| {
            let is_used = mentions(nominal, &nominal.inputs[i].name);
            laws(input, scales, |law| {
                Sketch::of_input(self, law, nominal, scales, i).require(is_used, Reason::Idle)
            })
        });
        let signals = scales.signals.iter().enumerate().flat_map(|(i, signal)| {
            laws(signal, scales, |law| Sketch::of_signal(self, law, nominal, scales, i))
        });
        inputs.chain(signals).map(Sketch::finish).collect()
    }
}

fn laws<'a>(
    input: &SignalScale,
    scales: &ReplayScales,
    sketch: impl Fn(&'static str) -> Sketch<'a>,
) -> [Sketch<'a>; 2] {
    let size = if input.moves() { input.std } else { input.peak() };
    let offset =
        |law| {
            sketch(law)
                .require(size > 0.0 && size.is_finite(), Reason::Still("the input"))
                .strength("o", "offset", &input.unit, size, [-5.0, 5.0])
        };
    [
        offset("constant").wrap_input("u + o").starts([[0.1]]),
        offset("stepwise")
            .shape("since", "offset_since", "s", scales.duration, [0.0, 1.0], 0.0)
            .onset("on", "offset_on", "since")
            .wrap_input("u + o*on")
            .in_another_run(InAnotherRun::GoesOn)
            .starts(ONSETS.map(|since| [0.1, since])),
    ]
}
