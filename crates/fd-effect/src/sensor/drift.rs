//! Drift of a sensor.

use fd_sim::{model::Model, scales::ReplayScales};

use super::places::each_output;
use crate::{Effect, InAnotherRun, Offers, units::per};

/// Drift `y + r t` since the beginning of the log, or one that settles, `y + a (1 - exp(-t/T))`.
#[derive(Clone, Copy, Debug)]
pub struct SensorDrift;

impl Effect for SensorDrift {
    fn label(&self) -> &'static str {
        "sensor-drift"
    }

    fn family(&self) -> &'static str {
        "sensor-offset"
    }

    fn is_signed(&self) -> bool {
        true
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        let length = scales.duration;
        let shortest = 2.0 * scales.ts / length;
        each_output(self, nominal, scales, |sketch, output| {
            vec![
                sketch("linear")
                    .strength(
                        "r",
                        "drift",
                        per(&output.unit, "s"),
                        output.std / length,
                        [-10.0, 10.0],
                    )
                    .wrap_output("y + r*t")
                    .in_another_run(InAnotherRun::GoesOn)
                    .starts([[0.1]]),
                sketch("settling")
                    .strength("a", "settling", &output.unit, output.std, [-10.0, 10.0])
                    .shape("T", "settling_time", "s", length, [shortest, 3.0], 3.0)
                    .wrap_output("y + a*(1 - exp(-t/T))")
                    .in_another_run(InAnotherRun::GoesOn)
                    .starts([[0.1, 0.1], [0.1, 0.4]]),
            ]
        })
    }
}
