//! Scale error of a sensor.

use fd_sim::{model::Model, scales::ReplayScales};

use super::places::each_output;
use crate::{Effect, Offers};

/// Scale error `(1 + e) y`.
#[derive(Clone, Copy, Debug)]
pub struct SensorScale;

impl Effect for SensorScale {
    fn label(&self) -> &'static str {
        "sensor-scale"
    }

    fn family(&self) -> &'static str {
        "sensor-gain"
    }

    fn is_signed(&self) -> bool {
        true
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        each_output(self, nominal, scales, |sketch, _| {
            vec![
                sketch("linear")
                    .strength("e", "scale_error", "1", 1.0, [-0.9, 2.0])
                    .wrap_output("(1 + e)*y")
                    .starts([[0.05]]),
            ]
        })
    }
}
