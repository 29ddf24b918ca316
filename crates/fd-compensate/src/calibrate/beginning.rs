//! The beginning of a run in the threshold: what the start of a generator and a bias model leaves there.

use fd_core::stage::Detector;

use super::{error::LEAST_EXCEEDANCES, statistics::statistics, tail::Tail};
use crate::{decide::Debouncing, rows::DrivenRows};

/// The largest statistics of each beginning, ascending.
pub(super) fn peaks<D: Detector<f64> + ?Sized>(
    detector: &mut D,
    beginnings: DrivenRows<'_>,
    debouncing: Debouncing,
) -> Vec<f64> {
    let mut peaks: Vec<f64> = beginnings
        .runs()
        .map(|run| {
            let values = statistics(detector, beginnings, run, debouncing);
            values.into_iter().fold(f64::NEG_INFINITY, f64::max)
        })
        .collect();
    peaks.sort_unstable_by(f64::total_cmp);
    peaks
}

/// The threshold that a run exceeds with this probability, in its beginning or in one of `pieces` pieces of the rest:
/// the root of `1 − (1 − P_beginning(t)) (1 − P_piece(t))^pieces = probability`.
///
/// Beginning and rest are taken as independent, which is cautious where a loud one announces the other.
pub(super) fn threshold(beginnings: &[f64], rest: &Tail<'_>, pieces: f64, probability: f64) -> f64 {
    let begun = Tail {
        sorted: beginnings,
        resolved: (4.0 * LEAST_EXCEEDANCES / beginnings.len() as f64).min(0.5),
    };
    let alarms = |t: f64| {
        let silent = pieces * (-rest.exceeding(t)).ln_1p() + (-begun.exceeding(t)).ln_1p();
        -silent.exp_m1()
    };
    let least = |sorted: &[f64]| sorted.iter().copied().find(|v| v.is_finite());
    let most = |sorted: &[f64]| sorted.last().copied().filter(|v| v.is_finite());
    let ends = [beginnings, rest.sorted];
    let mut low = ends.iter().filter_map(|s| least(s)).fold(f64::INFINITY, f64::min);
    let mut high = ends.iter().filter_map(|s| most(s)).fold(f64::NEG_INFINITY, f64::max);
    // No finite value at all, or only one.
    if low >= high {
        return high.max(low.min(f64::MAX));
    }
    // Exponential tails fall by any factor within some multiples of the spread.
    for _ in 0..64 {
        if alarms(high) <= probability {
            break;
        }
        high += high - low;
    }
    for _ in 0..100 {
        let middle = low + 0.5 * (high - low);
        if alarms(middle) > probability { low = middle } else { high = middle }
    }
    high
}
