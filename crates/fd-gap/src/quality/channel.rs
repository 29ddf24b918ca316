//! Defects of a single channel that show without any model.

use super::{
    finding::Defect,
    noise_floor::{robust_third_difference_floor, third_difference_floor},
};

/// Part of the samples at a limit from which a channel counts as clipped.
const CLIPPED: f64 = 0.05;
/// A grid is coarse when its step is above this many times the noise between its points.
pub(crate) const COARSE_GRID: f64 = 0.5;
/// Part of the distinct values that may miss the grid.
const OFF_GRID: f64 = 0.01;
/// Samples per distinct value from which three are a grid.
const SHARED: usize = 20;
/// Distance from the grid, in steps, that counts as rounding.
const ROUNDING: f64 = 1e-3;
/// Correlation of neighbours below which sampling is too slow, in a signal well above its noise.
const SLOW: f64 = 0.5;

/// The step of the grid that all values lie on, if there is one: the smallest distance of two
/// distinct values, when nearly all of them are whole multiples of it apart. `None` for one or two
/// distinct values, which are always on some grid, and for three unless many samples share them.
///
/// ```
/// use fd_gap::quality::grid_step;
///
/// let coarse: Vec<f64> = (0..50).map(|k| 0.25 * (f64::from(k) * 0.3).sin().mul_add(20.0, 0.0).round()).collect();
/// assert_eq!(grid_step(&coarse), Some(0.25));
/// assert_eq!(grid_step(&[0.0, 1.0, std::f64::consts::PI, 10.0, 11.1]), None);
/// ```
#[must_use]
pub fn grid_step(signal: &[f64]) -> Option<f64> {
    let mut values: Vec<f64> = signal.iter().copied().filter(|v| v.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    values.dedup_by(|a, b| a.total_cmp(b).is_eq());
    let (first, last) = (*values.first()?, *values.last()?);
    // Differences of the same grid point after rounding are no step.
    let smallest = 1e-9 * (last - first);
    let gaps = values.windows(2).map(|w| w[1] - w[0]).filter(|gap| smallest < *gap);
    let step = gaps.fold(f64::INFINITY, f64::min);
    let fewest = if SHARED * values.len() < signal.len() { 3 } else { 4 };
    if values.len() < fewest || !step.is_finite() {
        return None;
    }
    let is_off = |v: &&f64| {
        let steps = (**v - first) / step;
        ROUNDING * steps.clamp(1.0, 0.25 / ROUNDING) < (steps - steps.round()).abs()
    };
    let off = values.iter().filter(is_off).count();
    (off as f64 <= OFF_GRID * values.len() as f64).then_some(step)
}

/// What is wrong with a channel. Inputs are made of steps, so that clipping, grids and fast changes
/// are no faults of theirs.
pub(super) fn defects(signal: &[f64], noise: Option<f64>, is_input: bool) -> Vec<Defect> {
    let values: Vec<f64> = signal.iter().copied().filter(|v| v.is_finite()).collect();
    let n = values.len().max(1) as f64;
    let mut found = Vec::new();
    if values.len() < signal.len() {
        found.push(Defect::Missing { share: 1.0 - values.len() as f64 / signal.len() as f64 });
    }
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if high <= low || values.is_empty() {
        found.push(Defect::Constant);
        return found;
    }
    if is_input {
        return found;
    }
    let grid = grid_step(signal);
    let third = third_difference_floor(signal).unwrap_or(0.0);
    let smooth = robust_third_difference_floor(signal).unwrap_or(0.0);
    if let Some(step) = grid.filter(|step| COARSE_GRID * smooth.max(noise.unwrap_or(0.0)) < *step) {
        found.push(Defect::Quantised { step });
    }
    for at in [low, high] {
        let share = values.iter().filter(|v| v.total_cmp(&at).is_eq()).count() as f64 / n;
        // The ends of a coarse grid are met often.
        let is_grid = grid.is_some_and(|step| high - low < 20.0 * step);
        if CLIPPED < share && !is_grid {
            found.push(Defect::Clipped { at, share });
        }
    }
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
    let noise = noise.unwrap_or(third);
    // A signal that is all noise has a variance of noise², give or take √(2/n) of it.
    if variance <= noise * noise * (1.0 + 4.0 * f64::sqrt(2.0 / n)) {
        found.push(Defect::NotExcited);
    } else if (10.0 * noise).powi(2) < variance || (noise - third).abs() < f64::EPSILON * third {
        let products = signal.windows(2).map(|w| (w[0] - mean) * (w[1] - mean));
        let correlation = products.filter(|p| p.is_finite()).sum::<f64>() / n / variance;
        if correlation < SLOW {
            found.push(Defect::SlowSampling { correlation });
        }
    }
    found
}
