//! Drag of a fluid.

use fd_sim::{model::Model, scales::ReplayScales};

use super::sites::each_site;
use crate::{Effect, Offers};

/// Drag `c |v| v`; with a free exponent `c V² |v/V|^p` in the direction of `v`, where `V` is the
/// usual velocity.
#[derive(Clone, Copy, Debug)]
pub struct Drag;

impl Effect for Drag {
    fn label(&self) -> &'static str {
        "drag"
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
            let scale = at.force() / (at.velocity() * at.velocity());
            let drag = |law| {
                sketch(law).with_velocity(at).strength(
                    "c",
                    "drag",
                    at.per_velocity(2),
                    scale,
                    [0.0, 4.0],
                )
            };
            vec![
                drag("quadratic").resist("drag_force", "c*abs(v)*v").starts([[0.05], [0.5]]),
                drag("power")
                    .shape("p", "drag_exponent", "1", 1.0, [1.2, 4.0], 2.0)
                    .bind("V", at.velocity())
                    // Below 1e-9 of the usual velocity the slope of the power stays finite.
                    .resist("drag_force", "c*V*v*max(abs(v/V), 1e-9)^(p - 1)")
                    .starts([[0.05, 1.5], [0.05, 3.0], [0.5, 1.5]]),
            ]
        })
    }
}
