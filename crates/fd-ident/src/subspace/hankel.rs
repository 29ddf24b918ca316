//! Windows of past and future samples, and what the future shares with the past beyond its inputs.

use std::borrow::Borrow;

use faer::Mat;
use fd_model::Record;
use fd_numeric::dense::Dense;

use crate::error::IdentError;

/// All windows of `2 horizon` complete samples, one per row: future inputs and a 1 if there is a
/// constant, past inputs, past outputs, future outputs. The 1 takes constants out of all that
/// follows it in the factorisation, as inputs are.
pub(super) fn windows<R: Borrow<Record>>(
    records: &[R],
    horizon: usize,
    constant: bool,
) -> Mat<f64> {
    let mut rows: Vec<Vec<f64>> = Vec::new();
    for record in records {
        let record = record.borrow();
        let mut complete = 0;
        for k in 0..record.len() {
            complete = if record.is_complete(k) { complete + 1 } else { 0 };
            if complete < 2 * horizon {
                continue;
            }
            let (start, middle) = (k + 1 - 2 * horizon, k + 1 - horizon);
            let u = |k: usize| record.u(k).iter().copied();
            let y = |k: usize| record.y(k).iter().copied();
            let row = (middle..=k)
                .flat_map(u)
                .chain(constant.then_some(1.0))
                .chain((start..middle).flat_map(u))
                .chain((start..middle).flat_map(y))
                .chain((middle..=k).flat_map(y));
            rows.push(row.collect());
        }
    }
    Mat::from_fn(rows.len(), rows.first().map_or(0, Vec::len), |i, j| rows[i][j])
}

/// Left singular vectors and singular values of `L₃₂`.
pub(super) fn future_from_past(
    windows: &Mat<f64>,
    horizon: usize,
    (nu, ny): (usize, usize),
    constant: bool,
) -> Result<(Mat<f64>, Vec<f64>), IdentError> {
    let r = windows.factor_qr().thin_R().to_owned();
    let (u, z, y) = (horizon * nu + usize::from(constant), horizon * (nu + ny), horizon * ny);
    // Rows of Rᵀ are the blocks of L.
    let l32 = Mat::from_fn(y, z, |i, j| r[(u + j, u + z + i)]);
    let svd = l32
        .economic_svd()
        .map_err(|_| IdentError::NoConvergence { what: "singular values of L32" })?;
    let values = svd.S().column_vector().iter().copied().collect();
    Ok((svd.U().to_owned(), values))
}
