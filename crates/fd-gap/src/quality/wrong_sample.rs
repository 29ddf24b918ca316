//! Single samples that are wrong.
//!
//! One sample that a transmission has garbled is a hundred times the noise, takes the fit with it, and is
//! "noise" in the answer. Where a few stand alone they are named with their rows and left out. Where
//! there are many it is a property of the sensor, which has causes of its own (outliers).
//!
//! *When not to use:* on inputs, which are made of jumps, and on outputs that show single blows.

use fd_model::Record;
use fd_numeric::robust_deviation;

use super::{channel::grid_step, finding::Defect};

/// Neighbours on either side.
pub(crate) const NEIGHBOURS: usize = 2;
/// Distance from the neighbours, in the robust spread of such distances, of a sample that is wrong …
const OFF: f64 = 15.0;
/// … and in the range of the neighbours themselves: they agree with each other, and not with it.
const ALONE: f64 = 4.0;
/// Distance in steps of the grid that values lie on.
const STEPS: f64 = 3.0;
/// Most wrong samples of an output of a log that are accidents.
pub(crate) const MOST_ACCIDENTS: usize = 3;

/// The rows in which a signal is wrong, from 0, if these are few.
///
/// ```
/// use fd_gap::quality::wrong_samples;
///
/// let mut signal: Vec<f64> = (0..200).map(|k| (0.1 * f64::from(k)).sin()).collect();
/// assert!(wrong_samples(&signal).is_empty());
/// signal[42] = 17.0;
/// assert_eq!(wrong_samples(&signal), [42]);
/// ```
#[must_use]
pub fn wrong_samples(signal: &[f64]) -> Vec<usize> {
    let distances: Vec<Option<Distance>> = (0..signal.len()).map(|k| distance(signal, k)).collect();
    let mut sizes: Vec<f64> = distances.iter().flatten().map(|d| d.from).collect();
    let Some(spread) = robust_deviation(&mut sizes) else { return Vec::new() };
    let step = grid_step(signal).unwrap_or(0.0);
    let is_wrong = |d: &Distance| {
        let least = (OFF * spread).max(ALONE * d.range).max(STEPS * step);
        0.0 < d.from && least < d.from
    };
    let wrong = distances.iter().enumerate().filter(|(_, d)| d.as_ref().is_some_and(is_wrong));
    let rows: Vec<usize> = wrong.map(|(k, _)| k).collect();
    if rows.len() <= MOST_ACCIDENTS { rows } else { Vec::new() }
}

/// Takes wrong samples out of the outputs of a record. Returns the channel of each and what there is to say
/// of it; samples are counted from the start of the record.
pub fn leave_out_wrong_samples(record: &mut Record) -> Vec<(String, Defect)> {
    let mut found = Vec::new();
    for c in 0..record.outputs().len() {
        let signal: Vec<f64> = record.output(c).collect();
        for row in wrong_samples(&signal) {
            let Some(defect) = wrong_sample(&signal, row) else { continue };
            found.push((record.outputs()[c].name.clone(), defect));
            record.y_mut(row)[c] = f64::NAN;
        }
    }
    found
}

/// A wrong sample beside its neighbours; `None` where it has none.
pub(crate) fn wrong_sample(signal: &[f64], row: usize) -> Option<Defect> {
    let around = neighbours(signal, row, NEIGHBOURS);
    let around = [*around.first()?, *around.last()?];
    Some(Defect::WrongSample { row, found: *signal.get(row)?, around })
}

/// How far a sample is from its neighbours.
struct Distance {
    /// From the middle of them.
    from: f64,
    /// How far they are apart.
    range: f64,
}

/// `None` at the ends and where something is missing.
fn distance(signal: &[f64], k: usize) -> Option<Distance> {
    let around = neighbours(signal, k, NEIGHBOURS);
    if around.len() < 2 * NEIGHBOURS || !signal[k].is_finite() {
        return None;
    }
    let middle = 0.5 * (around[NEIGHBOURS - 1] + around[NEIGHBOURS]);
    let range = around[around.len() - 1] - around[0];
    Some(Distance { from: (signal[k] - middle).abs(), range })
}

/// Finite neighbours of a sample, up to so many on either side, in rising order.
pub(crate) fn neighbours(signal: &[f64], k: usize, reach: usize) -> Vec<f64> {
    let (from, to) = (k.saturating_sub(reach), (k + reach).min(signal.len() - 1));
    let mut near: Vec<f64> =
        (from..=to).filter(|i| *i != k).map(|i| signal[i]).filter(|v| v.is_finite()).collect();
    near.sort_by(f64::total_cmp);
    near
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_edges_and_many_are_no_accidents() {
        let steps: Vec<f64> = (0..300).map(|k| f64::from(k / 50 % 2)).collect();
        assert!(wrong_samples(&steps).is_empty());
        // A grid of a tenth, on which one value is two steps off.
        let mut coarse: Vec<f64> = (0..300).map(|k| (f64::from(k) * 0.05).floor() * 0.1).collect();
        coarse[100] += 0.2;
        assert!(wrong_samples(&coarse).is_empty());
        let mut many: Vec<f64> = (0..300).map(|k| (f64::from(k) * 0.05).sin()).collect();
        for k in (20..300).step_by(40) {
            many[k] = 30.0;
        }
        assert!(wrong_samples(&many).is_empty());
    }
}
