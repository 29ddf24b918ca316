//! Dead zone of an actuator.

use fd_sim::{model::Model, scales::ReplayScales};

use super::places::{each_place, either_way};
use crate::{Effect, Offers};

/// Dead zone of half width `w`: what is left is shifted, not scaled. In the asymmetric law it goes
/// from `-w (1 - a)` to `w (1 + a)`.
#[derive(Clone, Copy, Debug)]
pub struct InputDeadZone;

impl Effect for InputDeadZone {
    fn label(&self) -> &'static str {
        "input-dead-zone"
    }

    fn family(&self) -> &'static str {
        "actuator-nonlinearity"
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        each_place(self, nominal, scales, |sketch, input| {
            let zone = |law| {
                sketch(law).strength("w", "dead_zone", &input.unit, input.peak(), [0.0, 0.95])
            };
            vec![
                zone("symmetric").wrap_input("u - clamp(u, -w, w)").starts([
                    [0.02],
                    [0.08],
                    [0.2],
                    [0.45],
                ]),
                zone("asymmetric")
                    .shape("a", "dead_zone_asymmetry", "1", 1.0, [-1.0, 1.0], 0.0)
                    .wrap_input("u - clamp(u, -w*(1 - a), w*(1 + a))")
                    .starts(either_way([0.08, 0.3, 0.45])),
            ]
        })
    }
}
