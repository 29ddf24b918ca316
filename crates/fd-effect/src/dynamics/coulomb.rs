//! Coulomb friction and its relatives.

use fd_sim::{model::Model, scales::ReplayScales};

use super::sites::{SiteUnits, each_site};
use crate::{Effect, Offers, Sketch};

/// Dry friction `f s` with the set-valued sign `s ∈ Sgn(v)` of the velocity: `±f` in motion, and at rest
/// whatever keeps it at rest, up to `f`.
///
/// * Direction-dependent: `f (1 ± a)` for the two directions.
/// * Stribeck: `f + g exp(-(v/w)²)`, at rest up to `f + g`; the velocity `w` may be a two-hundredth of the usual one,
///   where only what holds at rest is more.
/// * Load-dependent: `f + m |N|`, where `N` is the force that the nominal model has at the site,
///   the sum of what drives and what holds: what accelerates.
/// * Gear: `f + m |D - H|`, where `D` is the part of that force that the inputs drive and `H` the
///   rest, such as a weight: what is transmitted (Duclusaud et al. 2025, arXiv 2410.08650, model
///   M3). A drive that only holds a weight rubs.
///
/// Where the equations of motion are known, the sign is found implicitly ([`fd_sim::model::Sign`]). A simulator outside
/// shows only velocities `v_k` and what a force does to them in a step, `K`; there the force of the step before and the
/// change of the velocity that came of it tell what the velocity would become, and the friction of the next step is
/// `clamp(b + (2 v_k - v_(k-1))/K, -h, h)`, with `b` that of the step before and `h` the level: zero velocity at the end of
/// the next step where the acceleration is constant, and no creep. A load that jumps is met one step late, and where it
/// leaves friction little to spare, what it pushed in that step is braked by no more than that.
#[derive(Clone, Copy, Debug)]
pub struct CoulombFriction;

impl Effect for CoulombFriction {
    fn label(&self) -> &'static str {
        "coulomb-friction"
    }

    fn family(&self) -> &'static str {
        "friction"
    }

    fn dissipates(&self) -> bool {
        true
    }

    fn is_often_alike(&self) -> bool {
        true
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        each_site(self, nominal, scales, |sketch, at| {
            let unit = &at.site.unit;
            let dry = |law| {
                let sketch = sketch(law).with_velocity(at);
                sketch.strength("f", "coulomb", unit, at.force(), [0.0, 3.0])
            };
            let (held, helpers) = at.site.unforced(nominal);
            vec![
                rub(dry("symmetric"), at, "f").starts([[0.05], [0.3], [0.8]]),
                rub(
                    dry("direction-dependent").shape("a", "asymmetry", "1", 1.0, [-1.0, 1.0], 0.0),
                    at,
                    "f*(1 + a*sign(s))",
                )
                .starts([[0.05, 0.5], [0.3, 0.5], [0.3, -0.5]]),
                rub(
                    dry("stribeck").strength("g", "breakaway", unit, at.force(), [0.0, 3.0]).shape(
                        "w",
                        "stribeck_velocity",
                        at.velocity_unit(),
                        at.velocity(),
                        [0.005, 3.0],
                        0.3,
                    ),
                    at,
                    "f + g*exp(-(v/w)^2)",
                )
                .starts([
                    [0.05, 0.1, 0.3],
                    [0.2, 0.3, 0.2],
                    [0.5, 0.5, 0.6],
                    [0.2, 0.05, 0.02],
                ]),
                rub(
                    dry("load-dependent")
                        .require(at.site.has_equation(), super::sites::NO_EQUATION)
                        .strength("m", "per_load", "1", 1.0, [0.0, 1.0])
                        .with_helpers(&at.site.helpers)
                        .bind("A", at.site.acceleration.clone())
                        .bind("C", at.site.compliance.clone())
                        .define("N", "nominal_force", "A/C"),
                    at,
                    "f + m*abs(N)",
                )
                .starts([[0.05, 0.05], [0.02, 0.2], [0.3, 0.1]]),
                rub(
                    dry("gear")
                        .require(at.site.has_equation(), super::sites::NO_EQUATION)
                        .strength("m", "per_transmitted", "1", 1.0, [0.0, 1.0])
                        .with_helpers(&at.site.helpers)
                        .with_helpers(&helpers)
                        .bind("A", at.site.acceleration.clone())
                        .bind("H", held)
                        .bind("C", at.site.compliance.clone())
                        .define("N", "transmitted_force", "(A - 2*H)/C"),
                    at,
                    "f + m*abs(N)",
                )
                .starts([[0.05, 0.05], [0.02, 0.2], [0.3, 0.1]]),
            ]
        })
    }
}

/// Adds friction of a level, a template in which `s` has the sign of the velocity.
fn rub<'a>(sketch: Sketch<'a>, at: &SiteUnits<'_>, level: &str) -> Sketch<'a> {
    let name = "friction";
    if at.site.has_equation() {
        let sketch = sketch.sign("s", "direction", "v").define("h", "friction_level", level);
        return sketch.resist(name, "h*s");
    }
    sketch
        .memory("o", "velocity_before", &at.velocity_unit(), "v")
        .memory("b", "friction_before", &at.site.unit, "0")
        .bind("K", at.site.kick)
        .define("r", "arresting_force", "b + (2*v - o)/K")
        .abbreviate("s", "r")
        .define("h", "friction_level", level)
        .define("F", "friction", "clamp(r, -h, h)")
        .becomes("o", "v")
        .becomes("b", "F")
        .resist("friction_force", "F")
}
