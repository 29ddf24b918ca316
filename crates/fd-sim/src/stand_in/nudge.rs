//! How far parameters are moved for a slope.

use crate::simulate::Simulator;

/// How far something is moved for a slope, as a part of what it usually does: outputs may be rounded to seven digits,
/// and plants bend …
pub(super) const STEP: f64 = 1e-3;
/// … so that where dry friction holds, which lets go of what is moved farther, or a contact is open, they are moved by …
pub(super) const COARSE: f64 = 0.1;
/// … but where equal runs differ, no difference is worth anything that is not larger.
const LARGEST: f64 = 0.3;

/// How far something is moved, as a part of what it usually does: with an error `p` of the outputs and a curvature of
/// about one the best step is `√p`.
pub(super) fn part(simulator: &dyn Simulator) -> f64 {
    STEP.max(simulator.precision().sqrt().min(LARGEST))
}

/// By how much parameter `i`, now at `value`, is moved for a slope: within its bounds, and a native effect, which
/// rests at any value, by a part of what is noticed of it.
pub(super) fn nudge(simulator: &dyn Simulator, i: usize, value: f64) -> f64 {
    let (parameters, natives) = (simulator.parameters(), simulator.natives());
    let native = i.checked_sub(parameters.len() - natives.len()).and_then(|i| natives.get(i));
    let size = native.map_or(value.abs(), |native| native.size);
    let step = part(simulator) * if 0.0 < size { size } else { 1.0 };
    let is_inside = |[_, high]: [f64; 2]| value + step <= high;
    if parameters[i].bounds.is_none_or(is_inside) { step } else { -step }
}
