//! Lag of a sensor.

use fd_sim::{model::Model, scales::ReplayScales};

use super::each_output;
use crate::{
    Effect, Offers,
    input::{LONGEST, STARTS},
};

/// Lag with time constant `T`, at rest when a run starts. Between the starts of two integration
/// steps the measured quantity goes in a straight line, to which the response is exact: with
/// `k = exp(-dt/T)`, `q` the quantity and `b` the lagged value a step ago, it is
/// `y - (y - q) (1 - k) T/dt + (b - q) k`.
///
/// A continuous controller, which also measures within steps, sees this with an error of a
/// fraction of the step.
#[derive(Clone, Copy, Debug)]
pub struct SensorLag;

impl Effect for SensorLag {
    fn label(&self) -> &'static str {
        "sensor-lag"
    }

    fn family(&self) -> &'static str {
        "sensor-dynamics"
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        let longest = LONGEST.min(0.5 * scales.duration / scales.ts);
        each_output(self, nominal, scales, |sketch, output| {
            vec![
                sketch("order-1")
                    .strength("T", "lag", "s", scales.ts, [0.0, longest])
                    // The exponential of -1000 is zero already; the quotient stays finite.
                    .abbreviate("k", "exp(-dt/max(T, dt/1000))")
                    .memory("q", "before", &output.unit, "y")
                    .memory("b", "lagged", &output.unit, "y")
                    .define("now", "shown", "y - (y - q)*(1 - k)*T/dt + (b - q)*k")
                    .becomes("q", "y")
                    .becomes("b", "now")
                    .wrap_output("now")
                    .starts(STARTS),
            ]
        })
    }
}
