//! An end stop of a moving part.

use fd_sim::{model::Model, scales::ReplayScales};

use super::sites::{SiteUnits, each_site};
use crate::{Effect, Offers, Reason, Sketch, units::per};

/// A stop that pushes back with stiffness `k` beyond a distance `1/s` from the middle of the range
/// that the nominal model shows: at both ends, or at one. The strength is the inverse of the
/// distance, so that none is exactly none.
///
/// The real stops need not lie evenly around that middle: `between-stops` has a middle of its own.
/// `damped` has one, too, and takes energy out of each hit: with `E` the way into the stop and `v`
/// the velocity into it the push is `k E max(0, 1 + b v)`, after Hunt and Crossley (1975), who found
/// `b ≈ 1.5 (1 − e)/v₀` for a restitution `e` of hits at `v₀`.
#[derive(Clone, Copy, Debug)]
pub struct EndStop;

/// Distances of the stops from which to start, as fractions of half the range. Contact may happen
/// only at the very ends of what the log shows, and where these are is known no better than the
/// parameters: the fit may reach farther than the nominal model does.
const LEVELS: [f64; 8] = [0.92, 0.96, 1.0, 1.03, 0.88, 0.8, 0.62, 0.42];
/// So many of them are tried with a soft stop as well.
const SOFT: usize = 4;
/// Distances of stops that have a middle of their own, as fractions of half the range, how far that is from the middle of the
/// range, as another one, and their stiffness, of that of stiff ones: what is hit often is soft.
const UNEVEN: [[f64; 3]; 8] = [
    [0.92, 0.0, 1.0],
    [0.97, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [0.7, 0.0, 1.0],
    [0.6, 0.35, 0.2],
    [0.6, -0.35, 0.2],
    [0.4, 0.5, 0.2],
    [0.4, -0.5, 0.2],
];

impl Effect for EndStop {
    fn label(&self) -> &'static str {
        "end-stop"
    }

    fn family(&self) -> &'static str {
        "limit"
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        each_site(self, nominal, scales, |sketch, at| {
            let range = Range::of(at);
            let Range { middle, half } = range;
            let stiffness = at.force() / at.position();
            // Stiffness that Runge-Kutta integrates well: (h ω)² < 1/2.
            let stiffest = 0.5 / (stiffness * at.site.held_kick() * scales.step);
            let start = stiffest.min(50.0) / 2.5;
            let stop = |law| {
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
            };
            let even = |law, excess| {
                push(stop(law).bind("c", middle), excess)
                    .starts(LEVELS.map(|level| [1.0 / level, start]))
                    // A short touch of a stiff stop is like a longer one of a soft stop.
                    .starts(LEVELS[..SOFT].iter().map(|level| [1.0 / level, 0.2 * start]))
            };
            let uneven = |law| range.with_middle(stop(law), at);
            let shift = middle / half;
            vec![
                even("both", "d"),
                even("upper", "max(d, 0)"),
                even("lower", "min(d, 0)"),
                push(uneven("between-stops"), "d").starts(
                    UNEVEN.map(|[level, off, soft]| [1.0 / level, soft * start, shift + off]),
                ),
                uneven("damped")
                    .shape(
                        "b",
                        "stop_damping",
                        per("1", &at.velocity_unit()),
                        1.0 / at.velocity(),
                        [0.0, 10.0],
                        0.0,
                    )
                    .abbreviate("d", "x - c")
                    .define("E", "beyond_stop", "d - d/max(1, s*abs(d))")
                    .resist(
                        "stop_force",
                        "k*(max(E, 0)*max(0, 1 + b*v) + min(E, 0)*max(0, 1 - b*v))",
                    )
                    .starts(
                        UNEVEN.map(|[level, off, soft]| {
                            [1.0 / level, soft * start, shift + off, 0.5]
                        }),
                    ),
            ]
        })
    }
}

/// The push of `k` over an excess, a template of the distance `d` from the middle; it is exactly
/// zero for `s = 0`.
fn push<'a>(sketch: Sketch<'a>, excess: &str) -> Sketch<'a> {
    sketch
        .abbreviate("d", "x - c")
        .abbreviate("q", excess)
        .resist("stop_force", "k*(q - q/max(1, s*abs(q)))")
}

/// The range of the position in the nominal model.
#[derive(Clone, Copy)]
struct Range {
    middle: f64,
    half: f64,
}

impl Range {
    fn of(at: &SiteUnits<'_>) -> Self {
        let (low, high) =
            at.site.position.as_ref().map_or((0.0, 0.0), |(_, scale)| (scale.low, scale.high));
        let half = 0.5 * (high - low);
        Self { middle: low + half, half }
    }

    /// Lets the stops have a middle of their own, anywhere in the range.
    fn with_middle<'a>(self, sketch: Sketch<'a>, at: &SiteUnits<'_>) -> Sketch<'a> {
        let shift = self.middle / self.half;
        let bounds = [shift - 1.0, shift + 1.0];
        sketch.shape("c", "stop_middle", at.position_unit(), self.half, bounds, shift)
    }
}
