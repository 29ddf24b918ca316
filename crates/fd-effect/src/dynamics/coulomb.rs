//! Coulomb friction and its relatives.

use fd_sim::{model::Model, scales::ReplayScales};

use super::each_site;
use crate::{Effect, Offers};

/// Dry friction `f tanh(v/V)` with a creep velocity `V` of a fiftieth of the usual velocity, or
/// more where the integration step needs it.
///
/// * Direction-dependent: `f (1 ± a)` for the two directions.
/// * Stribeck: `f + g exp(-(v/w)²)`.
/// * Load-dependent: `f + m |N|`, where `N` is the force that the nominal model has at the site,
///   the sum of what drives and what holds: what accelerates.
/// * Gear: `f + m |D - H|`, where `D` is the part of that force that the inputs drive and `H` the
///   rest, such as a weight: what is transmitted (Duclusaud et al. 2025, arXiv 2410.08650, model
///   M3). A drive that only holds a weight rubs.
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

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        each_site(self, nominal, scales, |sketch, at| {
            let unit = &at.site.unit;
            let dry = |law| {
                sketch(law).with_creep(at).strength("f", "coulomb", unit, at.force(), [0.0, 3.0])
            };
            let name = "friction";
            let (held, helpers) = at.site.unforced(nominal);
            vec![
                dry("symmetric").resist(name, "f*tanh(v/max(V, K*f))").starts([
                    [0.05],
                    [0.3],
                    [0.8],
                ]),
                dry("direction-dependent")
                    .shape("a", "asymmetry", "1", 1.0, [-1.0, 1.0], 0.0)
                    .define("d", "direction", "tanh(v/max(V, K*f*(1 + abs(a))))")
                    .resist(name, "f*(1 + a*d)*d")
                    .starts([[0.05, 0.5], [0.3, 0.5], [0.3, -0.5]]),
                dry("stribeck")
                    .strength("g", "breakaway", unit, at.force(), [0.0, 3.0])
                    .shape(
                        "w",
                        "stribeck_velocity",
                        at.velocity_unit(),
                        at.velocity(),
                        [0.05, 3.0],
                        0.3,
                    )
                    .resist(name, "(f + g*exp(-(v/w)^2))*tanh(v/max(V, K*(f + g)))")
                    .starts([[0.05, 0.1, 0.3], [0.2, 0.3, 0.2], [0.5, 0.5, 0.6]]),
                dry("load-dependent")
                    .require(at.site.has_equation(), super::NO_EQUATION)
                    .strength("m", "per_load", "1", 1.0, [0.0, 1.0])
                    .with_helpers(&at.site.helpers)
                    .bind("A", at.site.acceleration.clone())
                    .bind("C", at.site.compliance.clone())
                    .define("N", "nominal_force", "A/C")
                    .define("h", "friction_level", "f + m*abs(N)")
                    .resist(name, "h*tanh(v/max(V, K*h))")
                    .starts([[0.05, 0.05], [0.02, 0.2], [0.3, 0.1]]),
                dry("gear")
                    .strength("m", "per_transmitted", "1", 1.0, [0.0, 1.0])
                    .with_helpers(&at.site.helpers)
                    .with_helpers(&helpers)
                    .bind("A", at.site.acceleration.clone())
                    .bind("H", held)
                    .bind("C", at.site.compliance.clone())
                    .define("N", "transmitted_force", "(A - 2*H)/C")
                    .define("h", "friction_level", "f + m*abs(N)")
                    .resist(name, "h*tanh(v/max(V, K*h))")
                    .starts([[0.05, 0.05], [0.02, 0.2], [0.3, 0.1]]),
            ]
        })
    }
}
