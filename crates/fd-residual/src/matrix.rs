//! Small matrix helpers that every design room needs.

use faer::{Mat, MatRef, Scale, c64};
use fd_core::{Shape, ShapeError};
use fd_model::{ModelError, NaturalUnits, StateSpace, TimeDomain};
use fd_numeric::dense::{Dense, Number};

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

/// Unit rows: each coordinate alone, then points spread over the sphere by multiples of powers of `1/φ`,
/// `φ^(width + 1) = φ + 1` (the generalised golden ratio of Roberts 2018).
pub(crate) fn spread_rows(width: usize) -> Vec<Mat<f64>> {
    /// Combinations besides each alone.
    const MIXTURES: usize = 24;

    /// Steps of the iteration `φ ← (1 + φ)^(1/(width + 1))`, of which each leaves at most a sixth of the error.
    const STEPS: usize = 24;

    let root = 1.0 / (width as f64 + 1.0);
    let ratio = (0..STEPS).fold(1.5_f64, |ratio, _| (1.0 + ratio).powf(root));
    let powers: Vec<f64> = std::iter::successors(Some(ratio.recip()), |power| Some(power / ratio))
        .take(width)
        .collect();
    let alone = (0..width).map(|i| Mat::from_fn(1, width, |_, j| if i == j { 1.0 } else { 0.0 }));
    let mixed = (1..=MIXTURES).filter(|_| 1 < width).map(|k| {
        let spread = |j: usize| 2.0 * (0.5 + k as f64 * powers[j]).fract() - 1.0;
        let row = Mat::from_fn(1, width, |_, j| spread(j));
        let size = row.norm_l2();
        Scale(size.recip()) * row
    });
    alone.chain(mixed).collect()
}

/// A matrix with complex entries and zero imaginary parts.
pub(crate) fn complex(m: MatRef<'_, f64>) -> Mat<c64> {
    Mat::from_fn(m.nrows(), m.ncols(), |i, j| c64::new(m[(i, j)], 0.0))
}

/// Orthonormal rows with the span of those of `m`, which are independent; its columns may have units that
/// make all rows look alike.
pub(crate) fn orthonormal_rows(m: &Mat<f64>) -> Mat<f64> {
    // Rotations from the left that leave the largest columns to the first rows: they round each column
    // relative to itself, and what remains is far from parallel.
    let staircase = m.pivoted_qr();
    let mut rows = staircase.R() * staircase.P();
    for i in 0..rows.nrows() {
        let unit = |rows: &mut Mat<f64>| {
            let size = rows.row(i).norm_l2();
            if size.is_normal() {
                (0..rows.ncols()).for_each(|j| rows[(i, j)] /= size);
            }
        };
        unit(&mut rows);
        // Twice is enough: what a second projection removes is rounding of the first.
        for _ in 0..2 {
            for before in 0..i {
                let along = rows.row(before) * rows.row(i).transpose();
                (0..rows.ncols()).for_each(|j| rows[(i, j)] -= along * rows[(before, j)]);
            }
            unit(&mut rows);
        }
    }
    rows
}

/// Largest singular value; zero for an empty matrix.
pub(crate) fn spectral_norm<T: Number>(m: MatRef<'_, T>) -> f64 {
    if m.nrows() == 0 || m.ncols() == 0 {
        return 0.0;
    }
    // The Frobenius norm is the safe side when the iteration fails (it never does for finite data).
    m.sigmas().ok().and_then(|s| s.first().copied()).unwrap_or_else(|| m.norm_l2())
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

/// The system with its states, and nothing else, in natural units.
pub(crate) fn with_natural_states<D: TimeDomain>(
    system: &StateSpace<D>,
) -> Result<StateSpace<D>, DesignError> {
    let states_only =
        NaturalUnits { inputs: Vec::new(), outputs: Vec::new(), ..system.natural_units() };
    Ok(system.in_units(&states_only)?)
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    /// Neither a combination with equal signs nor one with others is left out, where there are few.
    #[test]
    fn combinations_have_all_signs() {
        for width in 1..4 {
            let rows = spread_rows(width);
            assert!(rows.iter().all(|row| (row.norm_l2() - 1.0).abs() < 1e-12));
            let signs = rows[width..]
                .iter()
                .map(|row| (0..width).map(|j| 0.0 < row[(0, j)]).collect::<Vec<_>>());
            let signs: HashSet<Vec<bool>> = signs.collect();
            assert_eq!(signs.len(), if width == 1 { 0 } else { 1 << width });
        }
    }

    /// No two coordinates go together: independent ones would be off zero by `1/√24` = 0.2 as a rule.
    #[test]
    fn coordinates_of_combinations_are_not_correlated() {
        for width in 2..7 {
            let rows = spread_rows(width);
            let of = |j: usize| rows[width..].iter().map(|row| row[(0, j)]).collect::<Vec<f64>>();
            for (i, j) in (0..width).flat_map(|i| (0..i).map(move |j| (i, j))) {
                let (a, b) = (of(i), of(j));
                let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
                let correlation = dot(&a, &b) / (dot(&a, &a) * dot(&b, &b)).sqrt();
                assert!(correlation.abs() < 0.5, "{i} and {j} of {width}: {correlation}");
            }
        }
    }
}
