//! Bias of a sensor.

use fd_sim::{model::Model, scales::ReplayScales};

use super::each_output;
use crate::{Effect, Offers};

/// Bias `y + b`.
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
            ]
        })
    }
}
