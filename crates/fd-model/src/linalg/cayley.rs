//! The Cayley transform that carries a continuous pair to a discrete one with the same gramian.

use faer::{Mat, MatRef};

use crate::{
    error::ModelError,
    linalg::solve::{identity_minus, solve},
};

/// `(αI − A)⁻¹ (αI + A)` and `√(2α) (αI − A)⁻¹ B`.
///
/// Both pairs have the same controllability gramian, whatever `α > 0` (Smith 1968).
pub(crate) fn cayley(
    a: MatRef<'_, f64>,
    b: MatRef<'_, f64>,
    alpha: f64,
) -> Result<(Mat<f64>, Mat<f64>), ModelError> {
    let (n, m) = (b.nrows(), b.ncols());
    let minus = identity_minus(alpha, a);
    let right = Mat::from_fn(n, n + m, |i, j| {
        if j < n {
            a[(i, j)] + if i == j { alpha } else { 0.0 }
        } else {
            (2.0 * alpha).sqrt() * b[(i, j - n)]
        }
    });
    let solution = solve("the shifted state matrix αI − A", minus.as_ref(), right.as_ref())?;
    Ok((solution.subcols(0, n).to_owned(), solution.subcols(n, m).to_owned()))
}
