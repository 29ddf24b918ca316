//! Rate limit of an actuator.

use super::each_input;
use crate::{
    effect::{Effect, Offers, ReplayScales, SignalScale, Sketch, units::per},
    model::Model,
};

/// Rate limit `1/s`: the strength is the inverse of the fastest rate, so that none is exactly none.
/// In the asymmetric law the inverse is `s (1 + a)` upwards and `s (1 - a)` downwards. A run starts
/// at the input.
///
/// With `D` the way to go and `n = s |D|/dt` the steps that takes, the mean over a step is
/// `u - D n/2` for `n < 1` and `u - D (1 - 1/(2 n))` beyond.
///
/// The `slowing` law is that of a position servo: from a distance `w` on it slows down, as a lag of
/// the time `s w`. It goes `t₁ = clamp(s (|D| − w), 0, dt)` at the full rate, to a distance of `A`, and
/// the rest of the step along an exponential.
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
                slow_down(
                    limit("slowing").shape(
                        "w",
                        "slow_within",
                        &input.unit,
                        input.std,
                        [0.0, 4.0],
                        0.0,
                    ),
                    input,
                    scales.step,
                )
                .starts([[0.7, 0.5], [2.5, 0.5], [8.0, 0.5], [22.0, 0.5]]),
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

/// Follows the input at the rate `1/s` and, within `w` of it, as a lag of `s w`.
fn slow_down<'a>(sketch: Sketch<'a>, input: &SignalScale, step: f64) -> Sketch<'a> {
    sketch
        .memory("b", "followed", &input.unit, "u")
        // Neither a lag of no time nor a way of no length may be divided by.
        .bind("T", 1e-9 * step)
        .bind("S", 1e-9 * step / input.std)
        .bind("U", 1e-12 * input.std)
        .abbreviate("D", "u - b")
        .define("q", "full_rate_time", "clamp(s*(abs(D) - w), 0, dt)")
        .define("A", "slow_way", "max(abs(D) - dt/max(s, S), min(abs(D), w))")
        .define("E", "slow_share", "exp(-(dt - q)/max(s*w, T))")
        .becomes("b", "u - D*A*E/max(abs(D), U)")
        .wrap_input("u - D*(q*(abs(D) + A)/2 + A*s*w*(1 - E))/(dt*max(abs(D), U))")
}
