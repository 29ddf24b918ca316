//! The Cayley transform that carries a continuous system to a discrete one with the same gramians.

use faer::{Mat, MatRef, Scale, prelude::Solve};
use fd_numeric::dense::Dense;

use crate::{
    error::ModelError,
    linalg::solve::{identity_minus, inverse},
};

/// The system `(αI − A)⁻¹ (αI + A)`, `√(2α) (αI − A)⁻¹ B` and `√(2α) C (αI − A)⁻¹`.
///
/// It has the same gramians as the continuous one, whatever `α > 0` (Smith 1968), and is stable
/// when that is. The `α` taken maps the slowest and the fastest mode to about the same distance
/// from the unit circle.
pub(crate) struct Cayley {
    alpha: f64,
    /// `(αI − A)⁻¹`.
    inverse: Mat<f64>,
}

impl Cayley {
    /// Of a matrix of at least one row.
    ///
    /// # Errors
    ///
    /// Returns an error when `A` has an eigenvalue at `α`, in the unstable region.
    pub(crate) fn new(a: MatRef<'_, f64>) -> Result<Self, ModelError> {
        let alpha = central_rate(a);
        let shifted = identity_minus(alpha, a);
        Ok(Self {
            alpha, inverse: inverse("the shifted state matrix αI − A", shifted.as_ref())?
        })
    }

    pub(crate) fn a(&self) -> Mat<f64> {
        let n = self.inverse.nrows();
        // αI + A = 2αI − (αI − A).
        Mat::from_fn(n, n, |i, j| {
            2.0 * self.alpha * self.inverse[(i, j)] - if i == j { 1.0 } else { 0.0 }
        })
    }

    pub(crate) fn b(&self, b: MatRef<'_, f64>) -> Mat<f64> {
        Scale((2.0 * self.alpha).sqrt()) * (&self.inverse * b)
    }

    pub(crate) fn c(&self, c: MatRef<'_, f64>) -> Mat<f64> {
        Scale((2.0 * self.alpha).sqrt()) * (c * &self.inverse)
    }
}

/// About the geometric mean of the sizes of the smallest and the largest eigenvalue of a matrix
/// of at least one row; positive.
///
/// Power iterations with `A` and `A⁻¹`, for a shift that need not be right: a factor of ten costs
/// about three doublings more, and no accuracy.
fn central_rate(a: MatRef<'_, f64>) -> f64 {
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
    let lu = a.lu();
    let (fastest, slowest) = (growth(&|x| a * x), growth(&|x| lu.solve(x)).recip());
    let central = (fastest * slowest).sqrt();
    // A singular matrix has a mode that does not die out, and any shift will show it.
    if central.is_normal() { central } else { 1.0 }
}
