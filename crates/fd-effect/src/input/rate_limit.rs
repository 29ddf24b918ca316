//! Rate limit of an actuator.

use fd_sim::{
    model::Model,
    scales::{ReplayScales, SignalScale},
};

use super::each_input;
use crate::{Effect, Offers, Sketch, units::per};

/// Rate limit `1/s`: the strength is the inverse of the fastest rate, so that none is exactly none.
/// In the asymmetric law the inverse is `s (1 + a)` upwards and `s (1 - a)` downwards. A run starts
/// at the input.
///
/// With `D` the way to go and `n = s |D|/dt` the steps that takes, the mean over a step is
/// `u - D n/2` for `n < 1` and `u - D (1 - 1/(2 n))` beyond.
#[derive(Clone, Copy, Debug)]
pub struct InputRateLimit;

impl Effect for InputRateLimit {
    fn label(&self) -> &'static str {
        "input-rate-limit"
    }

    fn family(&self) -> &'static str {
        "actuator-dynamics"
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        each_input(self, nominal, scales, |sketch, input| {
            let limit = |law| {
                let unit = per("s", &input.unit);
                let scale = scales.ts / input.std;
                sketch(law).limit("s", "rate_limit", unit, scale, [0.0, 120.0])
            };
            vec![
                follow(limit("symmetric"), input, "s*abs(D)/dt").starts([
                    [0.7],
                    [2.5],
                    [8.0],
                    [22.0],
                ]),
                follow(
                    limit("asymmetric").shape("a", "rate_asymmetry", "1", 1.0, [-1.0, 1.0], 0.0),
                    input,
                    "s*(abs(D) + a*D)/dt",
                )
                .starts([[2.5, 0.5], [2.5, -0.5], [12.0, 0.5], [12.0, -0.5]]),
            ]
        })
    }
}

/// Follows the input in `steps` integration steps.
fn follow<'a>(sketch: Sketch<'a>, input: &SignalScale, steps: &str) -> Sketch<'a> {
    sketch
        .memory("b", "followed", &input.unit, "u")
        .abbreviate("D", "u - b")
        .define("n", "steps_to_go", steps)
        .becomes("b", "u - D*(1 - 1/max(n, 1))")
        .wrap_input("u - D*(min(n, 1)/2 + (1 - 1/max(n, 1))/2)")
}
