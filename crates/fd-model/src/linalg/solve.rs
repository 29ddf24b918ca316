//! Linear systems whose matrix may be singular.

use faer::{Mat, MatRef, prelude::Solve};
use fd_numeric::dense::{Dense, Lu};

use crate::error::ModelError;

/// Solves `A X = B`.
///
/// # Errors
///
/// Returns an error when `A` is singular to working precision: Skeel's condition number
/// `‖|A⁻¹| |A|‖`, which does not depend on the scaling of the equations, reaches `1/ε`.
pub(crate) fn solve(
    role: &'static str,
    a: MatRef<'_, f64>,
    b: MatRef<'_, f64>,
) -> Result<Mat<f64>, ModelError> {
    if a.nrows() == 0 {
        return Ok(b.to_owned());
    }
    let (lu, _) = factorise(role, a)?;
    Ok(lu.solve(b))
}

/// The inverse of a matrix of at least one row, for those who need all of it.
///
/// # Errors
///
/// As [`solve`].
pub(crate) fn inverse(role: &'static str, a: MatRef<'_, f64>) -> Result<Mat<f64>, ModelError> {
    let (_, inverse) = factorise(role, a)?;
    Ok(inverse)
}

fn factorise(role: &'static str, a: MatRef<'_, f64>) -> Result<(Lu<f64>, Mat<f64>), ModelError> {
    let lu = a.lu();
    let inverse = lu.inverse();
    // The row sums of |A⁻¹| |A|.
    let sums = absolute_times(inverse.as_ref(), &absolute_times(a, &vec![1.0; a.ncols()]));
    let worst = sums.into_iter().fold(0.0, max_or_nan);
    if worst < f64::EPSILON.recip() {
        Ok((lu, inverse))
    } else {
        Err(ModelError::Singular { role })
    }
}

/// `|A| x`.
fn absolute_times(a: MatRef<'_, f64>, x: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; a.nrows()];
    for (column, x) in a.col_iter().zip(x) {
        for (sum, entry) in product.iter_mut().zip(column.iter()) {
            *sum += entry.abs() * x;
        }
    }
    product
}

/// Solves `X A = B`.
///
/// # Errors
///
/// Returns an error when `A` is singular to working precision.
pub(crate) fn solve_right(
    role: &'static str,
    a: MatRef<'_, f64>,
    b: MatRef<'_, f64>,
) -> Result<Mat<f64>, ModelError> {
    Ok(solve(role, a.transpose(), b.transpose())?.transpose().to_owned())
}

/// `σI − A`.
pub(crate) fn identity_minus(sigma: f64, a: MatRef<'_, f64>) -> Mat<f64> {
    Mat::from_fn(a.nrows(), a.ncols(), |i, j| if i == j { sigma - a[(i, j)] } else { -a[(i, j)] })
}

/// `(A + Aᵀ)/2`, to take rounding errors out of a matrix that is symmetric by construction.
pub(crate) fn symmetric(a: MatRef<'_, f64>) -> Mat<f64> {
    Mat::from_fn(a.nrows(), a.ncols(), |i, j| 0.5 * (a[(i, j)] + a[(j, i)]))
}

/// The larger of two numbers, or NaN when one of them is (unlike [`f64::max`]).
fn max_or_nan(x: f64, y: f64) -> f64 {
    if x.is_nan() || y.is_nan() { f64::NAN } else { x.max(y) }
}
