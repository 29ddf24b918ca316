//! Offset of an actuator.

use fd_sim::{
    model::Model,
    scales::{ReplayScales, SignalScale},
};

use crate::{Effect, Offers, Reason, Sketch};

/// Offset `u + o`. A constant input has one too.
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
        let offset = |sketch: Sketch<'_>, input: &SignalScale| {
            let size = if input.moves() { input.std } else { input.peak() };
            sketch
                .require(size > 0.0 && size.is_finite(), Reason::Still("the input"))
                .strength("o", "offset", &input.unit, size, [-5.0, 5.0])
                .wrap_input("u + o")
                .starts([[0.1]])
                .finish()
        };
        let inputs = scales.inputs.iter().enumerate().map(|(i, input)| {
            offset(Sketch::of_input(self, "constant", nominal, scales, i), input)
        });
        let signals = scales.signals.iter().enumerate().map(|(i, signal)| {
            offset(Sketch::of_signal(self, "constant", nominal, scales, i), signal)
        });
        inputs.chain(signals).collect()
    }
}
