//! Frequencies at which transfer functions are looked at.

use std::f64::consts::PI;

use faer::Mat;
use fd_model::{ModelError, StateSpace, TimeDomain};

use crate::matrix::spectral_norm;

/// Points per decade of a frequency grid; two per pole are added.
const PER_DECADE: f64 = 16.0;

/// Rates below this fraction of the fastest count as integrators and do not stretch the grid.
const INTEGRATOR: f64 = 1e-8;

/// Halvings of a bracket by golden section: the relative error of a peak is then below 1e-9.
const REFINEMENTS: usize = 40;

/// Zero, a logarithmic grid that reaches two decades beyond all corner frequencies, and these.
pub(crate) fn frequency_grid<D: TimeDomain>(
    systems: &[&StateSpace<D>],
) -> Result<Vec<f64>, ModelError> {
    let mut grid = vec![0.0];
    let mut highest = f64::INFINITY;
    for system in systems {
        highest = system.domain().highest_frequency();
        for pole in system.poles()? {
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
    Ok(grid)
}

/// Where a gain is largest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// Largest singular value of the transfer matrix.
    pub gain: f64,
    /// Frequency of the peak, in rad/s; infinite for the feedthrough of a continuous model.
    pub omega: f64,
}

/// The largest gain along the frequency axis, by a grid with all corners and a golden section
/// around each local maximum.
///
/// For a stable system this is its H-infinity norm. Unlike the norm it is also defined when
/// unstable states cancel, as in `H_y G_f` of an unstable plant.
pub(crate) fn peak_gain<D: TimeDomain>(system: &StateSpace<D>) -> Result<Peak, ModelError> {
    // A frequency on an undamped pole, cancelled or not, has no value and is passed over.
    let gain = |omega: f64| {
        system.frequency_response(omega).map_or(0.0, |g: Mat<_>| spectral_norm(g.as_ref()))
    };
    let grid = frequency_grid(&[system])?;
    let gains: Vec<f64> = grid.iter().map(|&omega| gain(omega)).collect();
    let feedthrough = Peak { gain: gain(f64::INFINITY), omega: f64::INFINITY };
    let bounded = system.domain().highest_frequency().is_finite();
    let mut best = if bounded { Peak { gain: 0.0, omega: 0.0 } } else { feedthrough };
    for (i, (&omega, &here)) in grid.iter().zip(&gains).enumerate() {
        let (left, right) = (i.saturating_sub(1), (i + 1).min(grid.len() - 1));
        if best.gain < here {
            best = Peak { gain: here, omega };
        }
        if gains[left] <= here && gains[right] <= here {
            let peak = refine(&gain, grid[left], grid[right]);
            if best.gain < peak.gain {
                best = peak;
            }
        }
    }
    Ok(best)
}

/// Golden section for the maximum of a function with one maximum between two frequencies.
fn refine(gain: &impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> Peak {
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
    if at_a < at_b { Peak { gain: at_b, omega: b } } else { Peak { gain: at_a, omega: a } }
}
