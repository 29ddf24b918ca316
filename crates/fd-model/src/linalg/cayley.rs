//! The Cayley transform that carries a continuous system to a discrete one with the same gramians.

use faer::{Mat, MatRef, Scale, prelude::Solve};

use crate::{
    error::ModelError,
    linalg::solve::{identity_minus, inverse},
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
    let inverse = inverse("the shifted state matrix αI − A", identity_minus(alpha, a).as_ref())?;
    let scale = Scale((2.0 * alpha).sqrt());
    let (b, c) = (scale * (&inverse * b), scale * (c * &inverse));
    // αI + A = 2αI − (αI − A).
    let a =
        Mat::from_fn(n, n, |i, j| 2.0 * alpha * inverse[(i, j)] - if i == j { 1.0 } else { 0.0 });
    Ok([a, b, c])
}

/// About the geometric mean of the sizes of the smallest and the largest eigenvalue of a matrix
/// of at least one row; positive.
///
/// Power iterations with `A` and `A⁻¹`, for a shift that need not be right: a factor of ten costs
/// about three doublings more, and no accuracy.
pub(crate) fn central_rate(a: MatRef<'_, f64>) -> f64 {
    const STEPS: i32 = 12;

    let growth = |map: &dyn Fn(&Mat<f64>) -> Mat<f64>| {
        // No structure that a plant may have is orthogonal to this.
        let mut x = Mat::from_fn(a.nrows(), 1, |i, _| 1.0 + 0.5 * (i as f64).sin());
        let mut logarithm = 0.0;
        for step in 0..STEPS {
            x = map(&x);
            let size = x.norm_l2();
            // The first half turns the vector into the direction that grows.
            if STEPS / 2 <= step {
                logarithm += size.ln();
            }
            x = Scale(size.recip()) * x;
        }
        (logarithm / f64::from(STEPS - STEPS / 2)).exp()
    };
    let lu = a.partial_piv_lu();
    let (fastest, slowest) = (growth(&|x| a * x), growth(&|x| lu.solve(x)).recip());
    let central = (fastest * slowest).sqrt();
    // A singular matrix has a mode that does not die out, and any shift will show it.
    if central.is_normal() { central } else { 1.0 }
}
