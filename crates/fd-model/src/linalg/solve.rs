//! Linear systems whose matrix may be singular.

use faer::{Mat, MatRef, linalg::solvers::PartialPivLu, prelude::Solve};

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
    Ok(checked_lu(role, a)?.solve(b))
}

/// Factorises a matrix of at least one row.
///
/// # Errors
///
/// As [`solve`].
pub(crate) fn checked_lu(
    role: &'static str,
    a: MatRef<'_, f64>,
) -> Result<PartialPivLu<f64>, ModelError> {
    let n = a.nrows();
    let lu = a.partial_piv_lu();
    let inverse = lu.solve(Mat::<f64>::identity(n, n));
    let absolute = |m: MatRef<'_, f64>| Mat::from_fn(n, n, |i, j| m[(i, j)].abs());
    let condition = absolute(inverse.as_ref()) * absolute(a);
    let worst = (0..n).map(|i| condition.row(i).sum()).fold(0.0, max_or_nan);
    if worst < f64::EPSILON.recip() { Ok(lu) } else { Err(ModelError::Singular { role }) }
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
