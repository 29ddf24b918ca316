//! Bias of a sensor.

use fd_sim::{model::Model, scales::ReplayScales};

use super::places::each_output;
use crate::{Effect, InAnotherRun, Offers};

/// Times of a step, as parts of the log, from which to start.
const ONSETS: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];

/// Bias `y + b`, all along or, `stepwise`, since some time.
#[derive(Clone, Copy, Debug)]
pub struct SensorBias;

impl Effect for SensorBias {
    fn label(&self) -> &'static str {
        "sensor-bias"
    }

    fn family(&self) -> &'static str {
        "sensor-offset"
    }

    fn is_signed(&self) -> bool {
        true
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        each_output(self, nominal, scales, |sketch, output| {
            vec![
                sketch("constant")
                    .strength("b", "bias", &output.unit, output.std, [-10.0, 10.0])
                    .wrap_output("y + b")
                    .starts([[0.1]]),
                sketch("stepwise")
                    .strength("b", "bias", &output.unit, output.std, [-10.0, 10.0])
                    .shape("since", "bias_since", "s", scales.duration, [0.0, 1.0], 0.0)
                    .wrap_output("y + b*clamp((t - since)/dt + 0.5, 0, 1)")
                    .in_another_run(InAnotherRun::GoesOn)
                    .starts(ONSETS.map(|since| [0.1, since])),
            ]
        })
    }
}
