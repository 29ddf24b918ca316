//! Friction with memory: presliding.

use fd_sim::{model::Model, scales::ReplayScales};

use super::sites::each_site;
use crate::{Effect, Offers};

/// Rate-independent hysteresis `f z` over a distance `D`, exact for any monotone motion.
///
/// * Dahl (exponent 1): `dz/dx = (1 - z sgn v)/D`, hence `z = s + (z - s) exp(-|dx|/D)`.
/// * Bouc-Wen (`n = 1`, `β = γ`): the same while the force grows, a straight line of slope `1/D`
///   while it goes back.
///
/// The memory is that of the start of the integration step before, so that the way since then is
/// known within a step. Where a site has a velocity only, its integral is the way.
#[derive(Clone, Copy, Debug)]
pub struct Hysteresis;

impl Effect for Hysteresis {
    fn label(&self) -> &'static str {
        "hysteresis"
    }

    fn family(&self) -> &'static str {
        "friction"
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        each_site(self, nominal, scales, |sketch, at| {
            let at_rest = |law| {
                let mut sketch = sketch(law)
                    .with_velocity(at)
                    .strength("f", "hysteresis", &at.site.unit, at.force(), [0.0, 3.0])
                    .shape("L", "presliding", at.position_unit(), at.position(), [0.01, 10.0], 1.0)
                    .bind("K", at.site.held_kick() * scales.step)
                    // Not stiffer than the integration step can take.
                    .abbreviate("D", "max(L, K*f)");
                if at.site.position.is_none() {
                    sketch = sketch.dynamic("x", "travel", &at.position_unit()).moves("x", "v");
                }
                sketch
                    .memory("q", "place_before", &at.position_unit(), "x")
                    .memory("z", "bristle", "1", "0")
                    .define("d", "way", "x - q")
                    .define("e", "decay", "exp(-abs(d)/D)")
                    .abbreviate("s", "if(d < 0, -1, 1)")
            };
            let law = |law, now| {
                at_rest(law)
                    .define("now", "bend", now)
                    .becomes("q", "x")
                    .becomes("z", "now")
                    .resist("hysteresis_force", "f*now")
                    .starts([[0.1, 0.1], [0.1, 0.4], [0.5, 0.2], [1.0, 0.5]])
            };
            vec![
                law("dahl", "s + (z - s)*e"),
                law(
                    "bouc-wen",
                    "s*if(z*s >= 0, 1 - (1 - z*s)*e, \
                     if(z*s + abs(d)/D < 0, z*s + abs(d)/D, 1 - exp(-(z*s + abs(d)/D))))",
                ),
            ]
        })
    }
}
