//! Linear regression whose coefficients have a Gaussian prior of unknown size.

use faer::Mat;
use fd_numeric::dense::Dense;

use super::columns::Column;

/// Grid of prior sizes: from where nothing could be seen to where everything is free.
const GRID: i32 = 60;
/// Part of the largest eigenvalue that is rounding.
const ROUNDING: f64 = 1e-12;

/// Coefficients of columns, after nuisances have taken what they can.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Regression {
    pub coefficients: Vec<f64>,
    /// Fall of the sum of squares, less what is expected of noise alone.
    pub explained: f64,
    /// Logarithm of the evidence over that of no coefficients.
    pub log_evidence: f64,
}

/// `r = N z + J f + e` with unit noise `e`, `z` of the given prior precisions (about zero), and
/// `f ~ N(0, s²)` with the `s` of the most evidence (`MacKay` 1992; type II maximum likelihood).
///
/// With `z` integrated out, `M = JᵀJ − JᵀN G⁻¹ NᵀJ = V Λ Vᵀ` and `β = Vᵀ(Jᵀr − JᵀN G⁻¹ Nᵀr)`,
/// `ln Z(s) = ½ Σ [s² βᵢ²/(1 + s² λᵢ) − ln(1 + s² λᵢ)]`.
///
/// `None` when the nuisances are not independent or an eigenvalue does not converge.
pub(super) fn regress(
    nuisances: &[(Column, f64)],
    columns: &[Column],
    r: &[f64],
) -> Option<Regression> {
    let (m, p) = (columns.len(), nuisances.len());
    let mut gram =
        Mat::from_fn(m, m, |i, j| if j <= i { columns[i].dot(&columns[j]) } else { 0.0 });
    let mut right: Vec<f64> = columns.iter().map(|column| column.dot_full(r)).collect();
    if 0 < p {
        let corner = Mat::from_fn(p, p, |i, j| {
            let precision = if i == j { nuisances[i].1 } else { 0.0 };
            nuisances[i].0.dot(&nuisances[j].0) + precision
        });
        let factor = corner.cholesky().ok()?;
        // L⁻¹ NᵀJ and L⁻¹ Nᵀr.
        let mut seen = Mat::from_fn(p, m + 1, |i, j| match columns.get(j) {
            Some(column) => nuisances[i].0.dot(column),
            None => nuisances[i].0.dot_full(r),
        });
        factor.solve_half(seen.as_mut());
        for i in 0..m {
            let dot = |j: usize| (0..p).map(|k| seen[(k, i)] * seen[(k, j)]).sum::<f64>();
            for j in 0..=i {
                gram[(i, j)] -= dot(j);
            }
            right[i] -= dot(m);
        }
    }
    let eigen = gram.symmetric_eigen().ok()?;
    let lambda: Vec<f64> = (0..m).map(|i| eigen.S()[i]).collect();
    let largest = lambda.iter().copied().fold(0.0, f64::max);
    if largest <= 0.0 {
        return None;
    }
    let lambda: Vec<f64> = lambda.iter().map(|l| l.max(ROUNDING * largest)).collect();
    let along = |i: usize| (0..m).map(|k| eigen.U()[(k, i)] * right[k]).sum::<f64>();
    let beta: Vec<f64> = (0..m).map(along).collect();
    let log_evidence = |s2: f64| -> f64 {
        let term = |(l, b): (&f64, &f64)| s2 * b * b / (1.0 + s2 * l) - (s2 * l).ln_1p();
        0.5 * lambda.iter().zip(&beta).map(term).sum::<f64>()
    };
    // A factor of 1.5 in s² hardly changes the evidence.
    let sizes = (-10..GRID).map(|i| 1.5_f64.powi(i) * 1e-3 / largest);
    let (best, s2) = sizes
        .map(|s2| (log_evidence(s2), s2))
        .fold((0.0, 0.0), |best, next| if best.0 < next.0 { next } else { best });
    let shrunk: Vec<f64> = lambda.iter().zip(&beta).map(|(l, b)| s2 * b / (1.0 + s2 * l)).collect();
    let coefficients =
        (0..m).map(|k| (0..m).map(|i| eigen.U()[(k, i)] * shrunk[i]).sum()).collect();
    let explained = lambda.iter().zip(&beta).zip(&shrunk).map(|((l, b), f)| {
        let taken = s2 * l / (1.0 + s2 * l);
        2.0 * f * b - f * f * l - taken * (2.0 - taken)
    });
    Some(Regression { coefficients, explained: explained.sum(), log_evidence: best })
}
