//! Frequencies at which transfer functions are evaluated.

use std::f64::consts::PI;

use faer::{Mat, c64, prelude::Solve};
use fd_model::{Continuous, Discrete, ModelError, StateSpace, TimeDomain};

use crate::matrix::complex;

/// Points per decade of a frequency grid; two per pole are added.
const PER_DECADE: f64 = 16.0;

/// Rates below this fraction of the fastest count as integrators and do not stretch the grid.
const INTEGRATOR: f64 = 1e-8;

/// A time axis with its stability boundary, along which frequencies in rad/s are counted.
pub trait FrequencyAxis: TimeDomain {
    /// The point `jω` or `e^{jωTs}` of a frequency in rad/s.
    fn boundary_point(&self, omega: f64) -> c64;

    /// The continuous eigenvalue, in 1/s, that stands for the same mode.
    fn rate(&self, eigenvalue: c64) -> c64;

    /// Highest frequency that means something, in rad/s.
    fn highest(&self) -> f64;
}

impl FrequencyAxis for Continuous {
    fn boundary_point(&self, omega: f64) -> c64 {
        c64::new(0.0, omega)
    }

    fn rate(&self, eigenvalue: c64) -> c64 {
        eigenvalue
    }

    fn highest(&self) -> f64 {
        f64::INFINITY
    }
}

impl FrequencyAxis for Discrete {
    fn boundary_point(&self, omega: f64) -> c64 {
        let (sin, cos) = (omega * self.ts.seconds()).sin_cos();
        c64::new(cos, sin)
    }

    fn rate(&self, eigenvalue: c64) -> c64 {
        eigenvalue.ln() / self.ts.seconds()
    }

    fn highest(&self) -> f64 {
        PI / self.ts.seconds()
    }
}

/// Value of the transfer function at a point of the complex plane; infinite or NaN on a pole.
pub(crate) fn response_of<D: TimeDomain>(system: &StateSpace<D>, point: c64) -> Mat<c64> {
    let d = complex(system.d());
    if system.nx() == 0 {
        return d;
    }
    let resolvent = Mat::from_fn(system.nx(), system.nx(), |i, j| {
        let pole = if i == j { point } else { c64::new(0.0, 0.0) };
        pole - system.a()[(i, j)]
    });
    complex(system.c()) * resolvent.partial_piv_lu().solve(complex(system.b())) + d
}

/// Zero, a logarithmic grid that reaches two decades beyond all corner frequencies, and these.
pub(crate) fn frequency_grid<D: FrequencyAxis>(
    systems: &[&StateSpace<D>],
) -> Result<Vec<f64>, ModelError> {
    let mut grid = vec![0.0];
    let mut highest = f64::INFINITY;
    for system in systems {
        let axis = system.domain();
        highest = axis.highest();
        for pole in system.poles()? {
            // A light mode peaks at its damped frequency Im p, others bend at |p|.
            let rate = axis.rate(pole);
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
