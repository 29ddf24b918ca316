//! A store that the model lacks, behind one that it has.

use fd_sim::{model::Model, scales::ReplayScales};

use super::sites::{each_site, moving, unit_of};
use crate::{Effect, Offers, Reason, units::per};

/// Time constants from which to start, in samples.
const STARTS: [f64; 5] = [3.0, 12.0, 50.0, 200.0, 800.0];

/// A second store that fills from the first and empties into it: a heat capacity behind the one that is measured,
/// dead volume beside a vessel, a part that creeps behind one that springs (Maxwell's element).
///
/// With `w` the level of the store that the site works on (its position, or the state it enters), the hidden one
/// follows it with time constant `T`, `s' = (w - s)/T`, and takes away `k (w - s)`. A run starts in equilibrium.
/// The level `s` is exact over an integration step for held `w`, and the plant sees its mean; for a `w` that moves the error
/// shrinks with the square of the step.
#[derive(Clone, Copy, Debug)]
pub struct HiddenStore;

impl Effect for HiddenStore {
    fn label(&self) -> &'static str {
        "hidden-store"
    }

    fn family(&self) -> &'static str {
        "store"
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        // Slower than half the log it is a drift, faster than two steps a part of the first store.
        let [shortest, longest] =
            [2.0 * scales.step / scales.ts, 0.5 * scales.duration / scales.ts];
        each_site(self, nominal, scales, |sketch, at| {
            let site = at.site;
            let level = site.level();
            let size = moving(level).map_or(f64::NAN, |signal| signal.std);
            let mut sketch =
                sketch("exchange").require(size > 0.0, Reason::Missing("level that moves"));
            if let Some((level, _)) = level {
                sketch = sketch.bind("w", level.clone());
            }
            let unit = unit_of(nominal, level);
            let per_level = per(&site.unit, &unit);
            let sketch = sketch
                .strength("k", "exchange", per_level, at.force() / size, [0.0, 4.0])
                .shape("T", "exchange_time", "s", scales.ts, [shortest, longest], shortest)
                .memory("s", "hidden_level", &unit, "w")
                .abbreviate("e", "exp(-dt/T)")
                .memory("o", "level_before", &unit, "w")
                .becomes("o", "w")
                // The mean of the level in the step, if it goes on as in the step before.
                .abbreviate("W", "1.5*w - 0.5*o")
                .becomes("s", "W + (s - W)*e")
                .define("m", "hidden_mean", "w + (s - w)*(1 - e)*T/dt")
                .resist("exchanged", "k*(w - m)");
            vec![sketch.starts(STARTS.map(|time| [0.2, time]))]
        })
    }
}
