//! Matrices column by column: entry by entry, the checks of indices cost more than most of what is done with the entries.

use faer::{Mat, MatRef};

/// A matrix of rows that follow each other.
pub(crate) fn from_rows(rows: &[f64], count: usize, width: usize) -> Mat<f64> {
    let mut matrix = Mat::zeros(count, width);
    for j in 0..width {
        let entries = rows.iter().skip(j).step_by(width);
        matrix.col_as_slice_mut(j).iter_mut().zip(entries).for_each(|(to, from)| *to = *from);
    }
    matrix
}

/// The matrix with each column times a number.
pub(crate) fn scaled(matrix: MatRef<'_, f64>, by: &[f64]) -> Mat<f64> {
    let mut scaled = Mat::zeros(matrix.nrows(), matrix.ncols());
    for (j, by) in by.iter().enumerate() {
        let entries = matrix.col(j).iter();
        scaled.col_as_slice_mut(j).iter_mut().zip(entries).for_each(|(to, from)| *to = from * by);
    }
    scaled
}

/// Whether no entry is infinite or NaN.
pub(crate) fn is_finite(matrix: MatRef<'_, f64>) -> bool {
    matrix.col_iter().all(|column| column.iter().all(|entry| entry.is_finite()))
}
