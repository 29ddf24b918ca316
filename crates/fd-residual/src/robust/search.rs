//! Eigenvalues for given weights, and the search for weights.

use faer::{Mat, Scale};
use fd_model::ModelError;
use fd_numeric::dense::Dense;

use super::moments::Moments;
use crate::{error::DesignError, kalman::symmetric};

/// Of the average variance of the window, so that a combination without any is not divided by zero.
const FLOOR: f64 = 1e-12;

/// Rows with the largest quotients for these weights, each of unit variance under them, and the quotients.
pub(super) fn best_rows(
    all: &[Moments],
    [lambda, mu]: [&[f64]; 2],
    count: usize,
) -> Result<(Mat<f64>, Vec<f64>), DesignError> {
    let mean = |weights: &[f64], of: fn(&Moments) -> &Mat<f64>| {
        let size = all.first().map_or(0, |moments| moments.healthy.nrows());
        let terms = all.iter().zip(weights);
        terms.fold(Mat::zeros(size, size), |sum, (moments, &w)| sum + Scale(w) * of(moments))
    };
    let (a, b) = (mean(lambda, |m| &m.healthy), mean(mu, |m| &m.faulty));
    let n = a.nrows();
    // In units in which every channel of the window has unit variance.
    let unit: Vec<f64> =
        (0..n).map(|i| if 0.0 < a[(i, i)] { a[(i, i)].sqrt() } else { 1.0 }).collect();
    let scaled = |m: &Mat<f64>, floor: f64| {
        Mat::from_fn(n, n, |i, j| {
            m[(i, j)] / (unit[i] * unit[j]) + if i == j { floor } else { 0.0 }
        })
    };
    let failed = || ModelError::NoConvergence { what: "robust residual rows", order: n };
    let eigen = scaled(&a, FLOOR).symmetric_eigen().map_err(|_| failed())?;
    let (u, values) = (eigen.U(), eigen.S().column_vector());
    // Ā⁻½; rounding leaves no variance below the floor.
    let root = Mat::from_fn(n, n, |i, j| u[(i, j)] / values[j].max(FLOOR).sqrt());
    let white = symmetric(&(root.transpose() * scaled(&b, 0.0) * &root));
    let eigen = white.symmetric_eigen().map_err(|_| failed())?;
    let (z, quotients) = (eigen.U(), eigen.S().column_vector());
    // In ascending order.
    let z = Mat::from_fn(n, count, |i, j| z[(i, n - 1 - j)]);
    let w = (root * z).transpose().to_owned();
    let w = Mat::from_fn(count, n, |i, j| w[(i, j)] / unit[j]);
    Ok((w, (0..count).map(|j| quotients[n - 1 - j].max(0.0)).collect()))
}

/// `w M wᵀ`.
pub(super) fn energy(w: &Mat<f64>, row: usize, m: &Mat<f64>) -> f64 {
    (w.row(row) * m * w.row(row).transpose()).max(0.0)
}

/// A row, what it achieves over all models, and what none exceeds.
pub(super) struct Found {
    pub w: Mat<f64>,
    pub achieved: f64,
    pub bound: f64,
}

/// Multiplicative weights on the models that decide.
pub(super) fn worst_case(all: &[Moments]) -> Result<Found, DesignError> {
    const ROUNDS: usize = 400;
    let count = all.len();
    let even = vec![(count as f64).recip(); count];
    let (mut lambda, mut mu) = (even.clone(), even);
    let mut best: Option<Found> = None;
    for round in 0..ROUNDS {
        let (w, quotients) = best_rows(all, [&lambda, &mu], 1)?;
        let healthy: Vec<f64> = all.iter().map(|m| energy(&w, 0, &m.healthy)).collect();
        let faulty: Vec<f64> = all.iter().map(|m| energy(&w, 0, &m.faulty)).collect();
        let largest = healthy.iter().copied().fold(0.0, f64::max);
        let least = faulty.iter().copied().fold(f64::INFINITY, f64::min);
        let achieved = if 0.0 < largest { least / largest } else { 0.0 };
        let before = best.take();
        let bound = before.as_ref().map_or(f64::INFINITY, |b| b.bound).min(quotients[0]);
        best = Some(match before {
            Some(found) if achieved <= found.achieved => Found { bound, ..found },
            _ => Found { w, achieved, bound },
        });
        // Steps that shrink like 1/√k, in units of the mean.
        let step = 1.0 / (1.0 + round as f64).sqrt();
        let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
        let (by_healthy, by_faulty) = (mean(&healthy), mean(&faulty));
        let spread = |weights: &mut [f64], values: &[f64], mean: f64, sign: f64| {
            if 0.0 < mean {
                for (weight, value) in weights.iter_mut().zip(values) {
                    *weight *= (sign * step * (value / mean - 1.0).clamp(-3.0, 3.0)).exp();
                }
            }
            let sum: f64 = weights.iter().sum();
            for weight in weights.iter_mut() {
                *weight /= sum;
            }
        };
        spread(&mut lambda, &healthy, by_healthy, 1.0);
        spread(&mut mu, &faulty, by_faulty, -1.0);
    }
    best.ok_or(DesignError::Empty { what: "model" })
}
