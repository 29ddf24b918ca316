//! Small matrix helpers that every design room needs.

use faer::{Mat, MatRef, c64, traits::ComplexField};
use fd_core::{Shape, ShapeError};
use fd_model::ModelError;

use crate::error::DesignError;

/// Assembles a matrix from rows of blocks. Blocks of one row have equally many rows, and all
/// rows of blocks the same widths; the callers' sizes are checked before.
pub(crate) fn blocks(rows: &[&[MatRef<'_, f64>]]) -> Mat<f64> {
    let nrows = rows.iter().map(|row| row.first().map_or(0, MatRef::nrows)).sum();
    let ncols = rows.first().map_or(0, |row| row.iter().map(MatRef::ncols).sum());
    let mut all = Mat::zeros(nrows, ncols);
    let mut i = 0;
    for row in rows {
        let mut j = 0;
        for block in *row {
            all.submatrix_mut(i, j, block.nrows(), block.ncols()).copy_from(block);
            j += block.ncols();
        }
        i += row.first().map_or(0, MatRef::nrows);
    }
    all
}

/// A matrix with complex entries and zero imaginary parts.
pub(crate) fn complex(m: MatRef<'_, f64>) -> Mat<c64> {
    Mat::from_fn(m.nrows(), m.ncols(), |i, j| c64::new(m[(i, j)], 0.0))
}

/// Largest singular value; zero for an empty matrix.
pub(crate) fn spectral_norm<T: ComplexField<Real = f64>>(m: MatRef<'_, T>) -> f64 {
    if m.nrows() == 0 || m.ncols() == 0 {
        return 0.0;
    }
    // The Frobenius norm is the safe side when the iteration fails (it never does for finite data).
    m.singular_values().ok().and_then(|s| s.first().copied()).unwrap_or_else(|| m.norm_l2())
}

/// Checks the size of a given matrix.
pub(crate) fn check_shape(
    role: &'static str,
    matrix: MatRef<'_, f64>,
    expected: Shape,
) -> Result<(), DesignError> {
    let found = Shape::new(matrix.nrows(), matrix.ncols());
    if found != expected {
        return Err(ShapeError { role, expected, found }.into());
    }
    for col in 0..matrix.ncols() {
        for row in 0..matrix.nrows() {
            let value = matrix[(row, col)];
            if !value.is_finite() {
                return Err(ModelError::NonFinite { role, row, col, value }.into());
            }
        }
    }
    Ok(())
}
