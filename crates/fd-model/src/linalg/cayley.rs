//! The Cayley transform that carries a continuous system to a discrete one with the same gramians.

use faer::{Mat, MatRef, Scale, prelude::Solve};

use crate::{
    error::ModelError,
    linalg::solve::{checked_lu, identity_minus},
};

/// `(αI − A)⁻¹ (αI + A)`, `√(2α) (αI − A)⁻¹ B` and `√(2α) C (αI − A)⁻¹`.
///
/// Both systems have the same gramians, whatever `α > 0` (Smith 1968).
pub(crate) fn cayley(
    a: MatRef<'_, f64>,
    b: MatRef<'_, f64>,
    c: MatRef<'_, f64>,
    alpha: f64,
) -> Result<[Mat<f64>; 3], ModelError> {
    let n = a.nrows();
    let lu = checked_lu("the shifted state matrix αI − A", identity_minus(alpha, a).as_ref())?;
    let plus = Mat::from_fn(n, n, |i, j| a[(i, j)] + if i == j { alpha } else { 0.0 });
    let scale = (2.0 * alpha).sqrt();
    let (b, c) = (Scale(scale) * b, Scale(scale) * c.transpose());
    Ok([lu.solve(plus), lu.solve(b), lu.solve_transpose(c).transpose().to_owned()])
}
