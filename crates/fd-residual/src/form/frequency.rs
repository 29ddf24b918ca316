//! Frequencies at which transfer functions are looked at.

use std::f64::consts::PI;

use faer::{Mat, c64};
use fd_model::{ModelError, PeakGain, StateSpace, TimeDomain};

use crate::matrix::spectral_norm;

/// Points per decade of a frequency grid; two per pole are added.
const PER_DECADE: f64 = 16.0;

/// Rates below this fraction of the fastest count as integrators and do not stretch the grid.
const INTEGRATOR: f64 = 1e-8;

/// Frequencies closer to a pole than this, relatively, are passed over.
const NEAR: f64 = 1e-6;

/// Relative tolerance of H-infinity norms.
const TOLERANCE: f64 = 1e-8;

/// Steps of golden section in a bracket: the relative error of a peak is then below 1e-9.
const REFINEMENTS: usize = 40;

/// Whether a transfer function has digits at this frequency: no pole is so close that the
/// resolvent amplifies rounding to more than about 1e-9.
pub(crate) fn is_clear<D: TimeDomain>(domain: D, poles: &[c64], omega: f64) -> bool {
    let point = domain.point(omega);
    poles.iter().all(|&pole| NEAR * pole.norm().max(point.norm()) < (point - pole).norm())
}

/// Zero, a logarithmic grid that reaches two decades beyond all corner frequencies, and these,
/// but for frequencies on a pole.
pub(crate) fn frequency_grid<D: TimeDomain>(
    systems: &[&StateSpace<D>],
) -> Result<Vec<f64>, ModelError> {
    let mut grid = vec![0.0];
    let Some(domain) = systems.first().map(|system| system.domain()) else { return Ok(grid) };
    let highest = domain.highest_frequency();
    let mut poles = Vec::new();
    for system in systems {
        for pole in system.poles()? {
            poles.push(pole);
            // On a sampled axis, z = exp(s Ts) with Ts = π / highest.
            let rate = if highest.is_finite() { pole.ln() * (highest / PI) } else { pole };
            // A light mode peaks at its damped frequency Im s, others bend at |s|.
            grid.extend([rate.norm(), rate.im.abs()]);
        }
    }
    // A dead-beat mode has an infinite rate; one at or above Nyquist adds nothing.
    grid.retain(|&w| 0.0 <= w && w < highest && w.is_finite());

    let fastest = grid.iter().copied().fold(0.0, f64::max);
    let fastest = if fastest > 0.0 { fastest } else { highest.min(1.0) };
    let slowest = grid.iter().copied().filter(|&w| INTEGRATOR * fastest < w);
    let low = slowest.fold(fastest, f64::min) * 1e-2;
    let high = (fastest * 1e2).min(highest);
    let count = (PER_DECADE * (high / low).log10()).ceil();
    let steps = (0..).map(f64::from).take_while(|&k| k <= count);
    grid.extend(steps.map(|k| low * (high / low).powf(k / count)));
    grid.sort_by(f64::total_cmp);
    grid.dedup();
    grid.retain(|&omega| is_clear(domain, &poles, omega));
    Ok(grid)
}

/// The largest gain along the frequency axis.
///
/// For a stable system this is its H-infinity norm. In `H_y G_f` of an unstable plant the unstable
/// states cancel but are still there, and have no norm; the peak is then searched on a grid with
/// all corners, by a golden section around each local maximum.
pub(crate) fn peak_gain<D: TimeDomain>(system: &StateSpace<D>) -> Result<PeakGain, ModelError> {
    match system.hinf_norm(TOLERANCE) {
        Err(ModelError::Unstable { .. } | ModelError::NoConvergence { .. }) => scan(system),
        peak => peak,
    }
}

fn scan<D: TimeDomain>(system: &StateSpace<D>) -> Result<PeakGain, ModelError> {
    // Between grid points there may still be an undamped pole, cancelled or not.
    let gain = |omega: f64| {
        system.frequency_response(omega).map_or(0.0, |g: Mat<_>| spectral_norm(g.as_ref()))
    };
    let grid = frequency_grid(&[system])?;
    let gains: Vec<f64> = grid.iter().map(|&omega| gain(omega)).collect();
    let end = system.domain().highest_frequency();
    let mut best = PeakGain { norm: gain(end), omega: end };
    for (i, (&omega, &here)) in grid.iter().zip(&gains).enumerate() {
        let (left, right) = (i.saturating_sub(1), (i + 1).min(grid.len() - 1));
        if best.norm < here {
            best = PeakGain { norm: here, omega };
        }
        if gains[left] <= here && gains[right] <= here {
            let peak = refine(&gain, grid[left], grid[right]);
            if best.norm < peak.norm {
                best = peak;
            }
        }
    }
    Ok(best)
}

/// Golden section for the maximum of a function with one maximum between two frequencies.
fn refine(gain: &impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> PeakGain {
    let ratio = (5.0_f64.sqrt() - 1.0) / 2.0;
    let inside = |low: f64, high: f64, part: f64| low + part * (high - low);
    let (mut a, mut b) = (inside(low, high, 1.0 - ratio), inside(low, high, ratio));
    let (mut at_a, mut at_b) = (gain(a), gain(b));
    for _ in 0..REFINEMENTS {
        if at_a < at_b {
            (low, a, at_a) = (a, b, at_b);
            b = inside(low, high, ratio);
            at_b = gain(b);
        } else {
            (high, b, at_b) = (b, a, at_a);
            a = inside(low, high, 1.0 - ratio);
            at_a = gain(a);
        }
    }
    let (norm, omega) = if at_a < at_b { (at_b, b) } else { (at_a, a) };
    PeakGain { norm, omega }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bracket_shrinks_onto_its_peak() {
        for k in 1..40 {
            let top = 0.05 * f64::from(k);
            let peak = refine(&|omega: f64| 3.0 - (omega - top).powi(2), 0.0, 2.0);
            // Two thirds of all digits of ω: a parabola is flat to rounding within √ε of its top.
            assert!((peak.omega - top).abs() < 1e-7, "{peak:?} {top}");
            assert!((peak.norm - 3.0).abs() < 1e-14, "{peak:?}");
        }
    }
}
