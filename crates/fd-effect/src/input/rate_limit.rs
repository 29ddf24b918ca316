//! Rate limit of an actuator.

use fd_sim::{model::Model, scales::ReplayScales};

use super::places::{FROM_REST, each_input, either_way, may_be_from_rest};
use crate::{Effect, Offers, Sketch, units::per};

/// Rate limit `1/s`: the strength is the inverse of the fastest rate, so that none is exactly none.
/// In the asymmetric law the inverse is `s (1 + a)` upwards and `s (1 - a)` downwards. A run starts
/// at the input, in the law `from-rest` at zero.
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
            let symmetric = |law, before| {
                follow(limit(law), &input.unit, before, "s*abs(D)/dt")
                    .starts([0.7, 2.5, 8.0, 22.0, 50.0, 95.0].map(|s| [s]))
            };
            let asymmetric =
                limit("asymmetric").shape("a", "rate_asymmetry", "1", 1.0, [-1.0, 1.0], 0.0);
            let mut laws = vec![
                symmetric("symmetric", "u"),
                follow(asymmetric, &input.unit, "u", "s*(abs(D) + a*D)/dt")
                    .starts(either_way([2.5, 12.0, 40.0, 90.0])),
            ];
            if may_be_from_rest(scales, input) {
                laws.push(symmetric("symmetric-from-rest", FROM_REST));
            }
            laws
        })
    }
}

/// Follows the input, from what it was `before`, in `steps` integration steps.
fn follow<'a>(sketch: Sketch<'a>, unit: &str, before: &str, steps: &str) -> Sketch<'a> {
    sketch
        .memory("b", "followed", unit, before)
        .abbreviate("D", "u - b")
        .define("n", "steps_to_go", steps)
        .becomes("b", "u - D*(1 - 1/max(n, 1))")
        .wrap_input("u - D*(min(n, 1)/2 + (1 - 1/max(n, 1))/2)")
}
