//! Lag of a sensor.

use fd_sim::{model::Model, scales::ReplayScales};

use super::places::each_output;
use crate::{
    Effect, Offers,
    input::{LONGEST, STARTS},
};

/// Lag of order 1 with time constant `T`, or of order 2 with a second time constant `r T`; at rest when a run starts. Between the starts of two integration
/// steps the measured quantity goes in a straight line, to which the response is exact: with
/// `k = exp(-dt/T)`, `q` the quantity and `b` the lagged value a step ago, it is
/// `y - (y - q) (1 - k) T/dt + (b - q) k`. A second lag `r T` behind the first one answers to the same
/// line and to what decays in the first, `c_1 = b - q + s T` with the slope `s = (y - q)/dt`:
/// `y - s T (1 + r) + c_1 k/(1 - r) + (b_2 - q + s T (1 + r) - c_1/(1 - r)) k_2`.
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

    fn is_often_alike(&self) -> bool {
        true
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        let longest = LONGEST.min(0.5 * scales.duration / scales.ts);
        each_output(self, nominal, scales, |sketch, output| {
            let lag = |law| {
                sketch(law)
                    .strength("T", "lag", "s", scales.ts, [0.0, longest])
                    // The exponential of -1000 is zero already; the quotient stays finite.
                    .abbreviate("k", "exp(-dt/max(T, dt/1000))")
                    .memory("q", "before", &output.unit, "y")
                    .memory("b", "lagged", &output.unit, "y")
                    .define("now", "shown", "y - (y - q)*(1 - k)*T/dt + (b - q)*k")
                    .becomes("q", "y")
                    .becomes("b", "now")
            };
            vec![
                lag("order-1").wrap_output("now").starts(STARTS),
                lag("order-2")
                    .shape("r", "lag_ratio", "1", 1.0, [0.0, 0.95], 0.0)
                    .abbreviate("k_2", "exp(-dt/max(r*T, dt/1000))")
                    .memory("b_2", "lagged_twice", &output.unit, "y")
                    .abbreviate("late", "(y - q)*T*(1 + r)/dt")
                    .abbreviate("c_1", "(b - q + (y - q)*T/dt)/(1 - r)")
                    .define("twice", "shown_twice", "y - late + c_1*k + (b_2 - q + late - c_1)*k_2")
                    .becomes("b_2", "twice")
                    .wrap_output("twice")
                    .starts([[0.5, 0.5], [2.0, 0.5], [6.0, 0.8], [15.0, 0.5]]),
            ]
        })
    }
}
