//! Load that depends on an angle, as gravity does.

use fd_sim::{model::Model, scales::ReplayScales};

use super::sites::each_site;
use crate::{Effect, Offers, Reason};

/// A torque `a sin(x)`, or `a sin(x) + b cos(x)` of an arm at any angle. Only where the position is
/// in radians or degrees.
#[derive(Clone, Copy, Debug)]
pub struct GravityLoad;

impl Effect for GravityLoad {
    fn label(&self) -> &'static str {
        "gravity-load"
    }

    fn family(&self) -> &'static str {
        "load"
    }

    fn is_signed(&self) -> bool {
        true
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        each_site(self, nominal, scales, |sketch, at| {
            let unit = at.position_unit();
            let radians = if unit == "deg" { std::f64::consts::PI / 180.0 } else { 1.0 };
            let load = |law| {
                sketch(law)
                    .with_position(at)
                    .require(unit == "rad" || unit == "deg", Reason::Missing("angle"))
                    .bind("k", radians)
                    .abbreviate("q", if unit == "deg" { "k*x" } else { "x" })
                    .strength("a", "gravity_sine", &at.site.unit, at.force(), [-5.0, 5.0])
            };
            vec![
                load("sine").force("gravity", "a*sin(q)").starts([[0.1], [-0.5]]),
                load("sine-cosine")
                    .strength("b", "gravity_cosine", &at.site.unit, at.force(), [-5.0, 5.0])
                    .force("gravity", "a*sin(q) + b*cos(q)")
                    .starts([[0.1, 0.1], [0.1, -0.1]]),
            ]
        })
    }
}
