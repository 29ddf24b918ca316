//! An end stop of a moving part.

use super::each_site;
use crate::{
    effect::{Effect, Offers, Reason, ReplayScales, units::per},
    model::Model,
};

/// A stop that pushes back with stiffness `k` beyond a distance `1/s` from the middle `c` of the range
/// that the nominal model shows: at both ends, or at one. The strength is the inverse of the
/// distance, so that none is exactly none.
#[derive(Clone, Copy, Debug)]
pub struct EndStop;

impl Effect for EndStop {
    fn label(&self) -> &'static str {
        "end-stop"
    }

    fn family(&self) -> &'static str {
        "limit"
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        each_site(self, nominal, scales, |sketch, at| {
            let (low, high) =
                at.site.position.as_ref().map_or((0.0, 0.0), |(_, scale)| (scale.low, scale.high));
            let half = 0.5 * (high - low);
            let stiffness = at.force() / at.position();
            // Stiffness that Runge-Kutta integrates well: (h ω)² < 1/2.
            let stiffest = 0.5 / (stiffness * at.site.kick * scales.step);
            let start = stiffest.min(50.0) / 2.5;
            let stop = |law, excess| {
                sketch(law)
                    .with_position(at)
                    .require(at.has_velocity(), Reason::Missing("velocity"))
                    .limit("s", "stop", per("1", &at.position_unit()), 1.0 / half, [0.0, 12.5])
                    .shape(
                        "k",
                        "stop_stiffness",
                        at.per_position(1),
                        stiffness,
                        [0.1 * start, stiffest],
                        start,
                    )
                    .bind("c", low + half)
                    .abbreviate("d", "x - c")
                    .abbreviate("q", excess)
                    // The push is exactly zero for s = 0.
                    .resist("stop_force", "k*(q - q/max(1, s*abs(q)))")
                    .starts([0.92, 0.8, 0.62].map(|level| [1.0 / level, start]))
            };
            vec![stop("both", "d"), stop("upper", "max(d, 0)"), stop("lower", "min(d, 0)")]
        })
    }
}
