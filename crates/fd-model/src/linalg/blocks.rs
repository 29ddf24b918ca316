//! Matrices put together from blocks.

use faer::{Mat, MatRef};

/// `[P 0; 0 S]`.
pub(crate) fn diagonal(p: MatRef<'_, f64>, s: MatRef<'_, f64>) -> Mat<f64> {
    lower(p, Mat::zeros(s.nrows(), p.ncols()).as_ref(), s)
}

/// `[P 0; R S]`.
pub(crate) fn lower(p: MatRef<'_, f64>, r: MatRef<'_, f64>, s: MatRef<'_, f64>) -> Mat<f64> {
    let (rows, cols) = (p.nrows(), p.ncols());
    Mat::from_fn(rows + s.nrows(), cols + s.ncols(), |i, j| match (i < rows, j < cols) {
        (true, true) => p[(i, j)],
        (true, false) => 0.0,
        (false, true) => r[(i - rows, j)],
        (false, false) => s[(i - rows, j - cols)],
    })
}

/// `[P; S]`.
pub(crate) fn stack(p: MatRef<'_, f64>, s: MatRef<'_, f64>) -> Mat<f64> {
    let rows = p.nrows();
    Mat::from_fn(
        rows + s.nrows(),
        p.ncols(),
        |i, j| {
            if i < rows { p[(i, j)] } else { s[(i - rows, j)] }
        },
    )
}

/// `[P S]`.
pub(crate) fn beside(p: MatRef<'_, f64>, s: MatRef<'_, f64>) -> Mat<f64> {
    let cols = p.ncols();
    Mat::from_fn(
        p.nrows(),
        cols + s.ncols(),
        |i, j| {
            if j < cols { p[(i, j)] } else { s[(i, j - cols)] }
        },
    )
}
