//! Lag of an actuator.

use fd_sim::{model::Model, scales::ReplayScales};

use super::places::each_place;
use crate::{Effect, Offers};

/// Longest time constant, in samples.
pub(crate) const LONGEST: f64 = 60.0;
/// Time constants from which to start, in samples.
pub(crate) const STARTS: [[f64; 1]; 4] = [[0.5], [2.0], [6.0], [15.0]];

/// Lag of order 1 with time constant `T`, or of order 2 with a second time constant `r T`. A run
/// starts at rest. The response to the held input is exact, and the plant sees its mean over the
/// integration step.
///
/// With `k = exp(-dt/T)` and `b` the state at the start of the step, the mean of order 1 is
/// `u + (b - u) (1 - k) T/dt`. Of order 2 the second state is `u + c_1 exp(-t/T) + c_2 exp(-t/(r
/// T))` with `c_1 = (b_1 - u)/(1 - r)` and `c_2 = b_2 - u - c_1`.
#[derive(Clone, Copy, Debug)]
pub struct InputLag;

impl Effect for InputLag {
    fn label(&self) -> &'static str {
        "input-lag"
    }

    fn family(&self) -> &'static str {
        "actuator-dynamics"
    }

    fn is_often_alike(&self) -> bool {
        true
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        let longest = LONGEST.min(0.5 * scales.duration / scales.ts);
        each_place(self, nominal, scales, |sketch, input| {
            let lag = |law| {
                sketch(law)
                    .strength("T", "lag", "s", scales.ts, [0.0, longest])
                    // The exponential of -1000 is zero already; the quotient stays finite.
                    .abbreviate("k", "exp(-dt/max(T, dt/1000))")
                    .memory("b", "lagged", &input.unit, "u")
                    .becomes("b", "u + (b - u)*k")
            };
            vec![
                lag("order-1").wrap_input("u + (b - u)*(1 - k)*T/dt").starts(STARTS),
                lag("order-2")
                    .shape("r", "lag_ratio", "1", 1.0, [0.0, 0.95], 0.0)
                    .abbreviate("k_2", "exp(-dt/max(r*T, dt/1000))")
                    .memory("b_2", "lagged_twice", &input.unit, "u")
                    .abbreviate("c_1", "(b - u)/(1 - r)")
                    .abbreviate("c_2", "b_2 - u - c_1")
                    .becomes("b_2", "u + c_1*k + c_2*k_2")
                    .wrap_input("u + (c_1*(1 - k) + c_2*(1 - k_2)*r)*T/dt")
                    .starts([[0.5, 0.5], [2.0, 0.5], [6.0, 0.8], [15.0, 0.5]]),
            ]
        })
    }
}
