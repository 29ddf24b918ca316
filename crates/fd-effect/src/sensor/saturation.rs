//! Saturation of a sensor.

use fd_sim::{model::Model, scales::ReplayScales};

use super::places::each_output;
use crate::{Effect, Offers, Sketch, units::per};

/// Saturation at a distance of `1/s` from the middle of the range that the nominal model shows: the
/// strength is the inverse of the distance, so that none is exactly none. At both ends, or at one.
/// What the real sensor calls its middle need not be that of the nominal range: `between-limits` has
/// a middle of its own, and so has `rounded`, which is `d / (1 + |s d|^n)^(1/n)` of the distance `d`
/// from it.
#[derive(Clone, Copy, Debug)]
pub struct SensorSaturation;

/// Limits from which to start, as fractions of half the range; the fit may reach farther than the
/// nominal model does.
const LEVELS: [f64; 8] = [0.96, 0.985, 1.01, 1.03, 0.92, 0.8, 0.62, 0.42];

impl Effect for SensorSaturation {
    fn label(&self) -> &'static str {
        "sensor-saturation"
    }

    fn family(&self) -> &'static str {
        "sensor-nonlinearity"
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        each_output(self, nominal, scales, |sketch, output| {
            let half = 0.5 * (output.high - output.low);
            let middle = output.low + half;
            let limit = |law| {
                let unit = per("1", &output.unit);
                sketch(law).limit("s", "limit", unit, 1.0 / half, [0.0, 12.5])
            };
            let even = |law, excess| {
                cut(limit(law).bind("c", middle), excess).starts(LEVELS.map(|level| [1.0 / level]))
            };
            let shift = middle / half;
            let uneven = |law| {
                let bounds = [shift - 1.0, shift + 1.0];
                limit(law).shape("c", "middle", &output.unit, half, bounds, shift)
            };
            vec![
                even("both", "d").said("s", [Some("c - 1/s"), Some("c + 1/s")]),
                even("upper", "max(d, 0)").said("s", [None, Some("c + 1/s")]),
                even("lower", "min(d, 0)").said("s", [None, Some("c - 1/s")]),
                cut(uneven("between-limits"), "d")
                    .said("s", [Some("c - 1/s"), Some("c + 1/s")])
                    .starts([0.96, 0.8, 0.5].map(|level| [1.0 / level, shift])),
                uneven("rounded")
                    .said("s", [Some("c - 1/s"), Some("c + 1/s")])
                    .shape("n", "sharpness", "1", 1.0, [1.2, 40.0], 40.0)
                    .abbreviate("d", "y - c")
                    // Below 1e-9 the power is lost in rounding, and its slope stays finite.
                    .wrap_output("y - (d - d/(1 + max(s*abs(d), 1e-9)^n)^(1/n))")
                    // The last two take 1 % and 0.1 % of half the range.
                    .starts(
                        [[1.0, 3.0], [1.5, 3.0], [0.5, 2.5], [0.16, 2.0], [0.05, 2.0]]
                            .map(|[s, n]| [s, shift, n]),
                    ),
            ]
        })
    }
}

/// Cuts an excess, a template of the distance `d` from the middle; what is cut off is exactly zero
/// for `s = 0`.
fn cut<'a>(sketch: Sketch<'a>, excess: &str) -> Sketch<'a> {
    sketch
        .abbreviate("d", "y - c")
        .abbreviate("q", excess)
        .wrap_output("y - (q - q/max(1, s*abs(q)))")
}
