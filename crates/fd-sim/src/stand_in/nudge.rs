//! How far parameters are moved for a slope.

use crate::simulate::Simulator;

/// A part of the size of a parameter: outputs may be rounded to seven digits, and plants bend.
const STEP: f64 = 1e-3;

/// By how much parameter `i`, now at `value`, is moved for a slope: within its bounds, and a native effect, which
/// rests at any value, by a part of what is noticed of it.
pub(super) fn nudge(simulator: &dyn Simulator, i: usize, value: f64) -> f64 {
    let (parameters, natives) = (simulator.parameters(), simulator.natives());
    let native = i.checked_sub(parameters.len() - natives.len()).and_then(|i| natives.get(i));
    let size = native.map_or(value.abs(), |native| native.size);
    let step = STEP * if 0.0 < size { size } else { 1.0 };
    let is_inside = |[_, high]: [f64; 2]| value + step <= high;
    if parameters[i].bounds.is_none_or(is_inside) { step } else { -step }
}
