//! Quadrature, for run lengths from integral equations.

use std::f64::consts::PI;

/// Nodes and weights of Gauss-Legendre quadrature on `[0, length]`, by Newton's method on the Legendre
/// polynomial from the classical starting values.
pub(super) fn gauss_legendre(n: usize, length: f64) -> Vec<(f64, f64)> {
    (0..n)
        .map(|i| {
            let mut x = (PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..100 {
                let value;
                (value, slope) = legendre(n, x);
                let step = value / slope;
                x -= step;
                if step.abs() <= f64::EPSILON {
                    break;
                }
            }
            let weight = 2.0 / ((1.0 - x * x) * slope * slope);
            (0.5 * length * (1.0 + x), 0.5 * length * weight)
        })
        .collect()
}

/// Legendre polynomial `P_n(x)` and its derivative, by the three-term recurrence.
fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut before, mut value) = (1.0, x);
    for i in 2..=n {
        let i = i as f64;
        (before, value) = (value, ((2.0 * i - 1.0) * x * value - (i - 1.0) * before) / i);
    }
    (value, n as f64 * (x * value - before) / (x * x - 1.0))
}
