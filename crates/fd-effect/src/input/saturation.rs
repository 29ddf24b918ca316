//! Saturation of an actuator.

use fd_sim::{model::Model, scales::ReplayScales};

use super::places::{each_place, either_way};
use crate::{Effect, Offers, Sketch, units::per};

/// Saturation at `±1/s`: the strength is the inverse of the limit, so that none is exactly none.
/// Hard `u / max(1, |s u|)`; soft `u / (1 + |s u|^n)^(1/n)`; asymmetric with `s (1 ± a)` for the
/// two signs; `tanh(s u)/s`; and a limit of one sign only.
#[derive(Clone, Copy, Debug)]
pub struct InputSaturation;

/// Limits from which to start, as fractions of the largest input.
const LEVELS: [f64; 5] = [0.97, 0.92, 0.8, 0.62, 0.42];

impl Effect for InputSaturation {
    fn label(&self) -> &'static str {
        "input-saturation"
    }

    fn family(&self) -> &'static str {
        "actuator-nonlinearity"
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        each_place(self, nominal, scales, |sketch, input| {
            let both = |law| limit(sketch(law), &input.unit, input.peak());
            let mut laws = vec![
                both("hard")
                    .wrap_input("u/max(1, s*abs(u))")
                    .starts(LEVELS.map(|level| [1.0 / level])),
                both("soft")
                    .shape("n", "sharpness", "1", 1.0, [1.2, 40.0], 40.0)
                    // Below 1e-9 the power is lost in rounding, and its slope stays finite.
                    .wrap_input("u/(1 + max(s*abs(u), 1e-9)^n)^(1/n)")
                    // The last one takes 2 % of the largest input.
                    .starts([[1.0 / 0.92, 8.0], [1.0 / 0.8, 3.0], [1.0 / 0.5, 3.0], [0.4, 3.0]]),
                both("tanh")
                    .bind("S", 1e-9 / input.peak())
                    .wrap_input("if(s > 0, tanh(s*u)/max(s, S), u)")
                    // The first one takes 1 % of the largest input.
                    .starts([[0.17], [0.5], [1.0], [1.6]]),
                both("asymmetric")
                    .shape("a", "limit_asymmetry", "1", 1.0, [-1.0, 1.0], 0.0)
                    .wrap_input("u/max(1, s*(abs(u) + a*u))")
                    .starts(either_way([1.5, 0.9, 3.0, 6.0, 11.0])),
            ];
            for (law, reach, limited) in
                [("upper", input.high, "u/max(1, s*u)"), ("lower", -input.low, "u/max(1, -s*u)")]
            {
                // What never has this sign is not limited there.
                if 0.0 < reach {
                    let law = limit(sketch(law), &input.unit, reach).wrap_input(limited);
                    laws.push(law.starts(LEVELS.map(|level| [1.0 / level])));
                }
            }
            laws
        })
    }
}

/// A limit that is at first at what the signal reaches.
fn limit<'a>(sketch: Sketch<'a>, unit: &str, reach: f64) -> Sketch<'a> {
    sketch.limit("s", "limit", per("1", unit), 1.0 / reach, [0.0, 12.5])
}
