//! Definiteness of symmetric matrices.

use faer::{Mat, MatRef};
use fd_numeric::dense::DenseReal;

use crate::error::ModelError;

/// Whether a matrix is symmetric with all eigenvalues at least `floor` times the largest.
///
/// Negative eigenvalues within rounding of zero are let through when `floor` is zero. The
/// diagonal is scaled to ones first, so that the answer does not depend on units.
pub(crate) fn is_positive(a: MatRef<'_, f64>, floor: f64) -> Result<bool, ModelError> {
    let n = a.nrows();
    let rounding = 16.0 * n as f64 * f64::EPSILON;
    let size = |i: usize| a[(i, i)].abs().sqrt();
    for i in 0..n {
        if !a[(i, i)].is_finite() || a[(i, i)] < 0.0 {
            return Ok(false);
        }
        for j in 0..i {
            let scale = size(i) * size(j);
            let alike = (a[(i, j)] - a[(j, i)]).abs() <= rounding * scale;
            let bounded = a[(i, j)].abs() <= (1.0 + rounding) * scale;
            if !(alike && bounded) {
                return Ok(false);
            }
        }
    }
    let scaled = Mat::from_fn(n, n, |i, j| {
        let scale = size(i) * size(j);
        if 0.0 < scale { a[(i, j)] / scale } else { 0.0 }
    });
    if n == 0 {
        return Ok(true);
    }
    let values = scaled
        .symmetric_eigenvalues()
        .map_err(|_| ModelError::NoConvergence { what: "eigenvalues of a weight", order: n })?;
    let smallest = values.iter().copied().fold(f64::INFINITY, f64::min);
    Ok(if 0.0 < floor { floor < smallest } else { -rounding <= smallest })
}
