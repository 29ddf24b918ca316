//! Delay of a sensor.

use fd_sim::{model::Model, scales::ReplayScales};

use super::places::each_output;
use crate::{Effect, Offers, input::delays};

/// Delay by any fraction of a sample; between integration steps the past is interpolated.
#[derive(Clone, Copy, Debug)]
pub struct SensorDelay;

impl Effect for SensorDelay {
    fn label(&self) -> &'static str {
        "sensor-delay"
    }

    fn family(&self) -> &'static str {
        "sensor-dynamics"
    }

    fn is_often_alike(&self) -> bool {
        true
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        let (longest, starts) = delays(scales);
        each_output(self, nominal, scales, |sketch, _| {
            vec![
                sketch("pure")
                    .strength("T", "delay", "s", scales.ts, [0.0, longest])
                    .delay("late", "delayed", "y", "T")
                    .wrap_output("late")
                    .starts(starts.clone()),
            ]
        })
    }
}
