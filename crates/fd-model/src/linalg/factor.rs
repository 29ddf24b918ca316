//! Factors of gramians by doubling.

use faer::{Mat, MatRef, concat};

use crate::error::ModelError;

/// A factor `L` of the solution `P = L Lᵀ` of `A P Aᵀ − P + B Bᵀ = 0`, for a stable `A`.
///
/// Squared Smith iteration (Smith 1968) on the factor: `L ← [L, A L]`, `A ← A²`, with an
/// orthogonal compression to at most as many columns as states. `P` is never formed, so that
/// small Hankel values survive as they do in Hammarling's method.
///
/// # Errors
///
/// Returns an error when `A` is too close to instability to converge.
pub(crate) fn smith_factor(a: &Mat<f64>, b: &Mat<f64>) -> Result<Mat<f64>, ModelError> {
    // 2⁶⁴ steps: only an eigenvalue that is on the unit circle to rounding needs more.
    const DOUBLINGS: usize = 64;

    let (mut power, mut factor) = (a.clone(), b.clone());
    for _ in 0..DOUBLINGS {
        let moved = &power * &factor;
        let (step, size) = (moved.norm_l2(), factor.norm_l2());
        if !size.is_finite() || !step.is_finite() {
            break;
        }
        if step <= f64::EPSILON * size {
            return Ok(factor);
        }
        factor = compress(concat![[factor, moved]].as_ref());
        power = &power * &power;
    }
    Err(ModelError::NoConvergence { what: "the gramian", order: a.nrows() })
}

/// A factor of the same product with at most as many columns as rows.
fn compress(factor: MatRef<'_, f64>) -> Mat<f64> {
    if factor.ncols() <= factor.nrows() {
        return factor.to_owned();
    }
    factor.transpose().qr().thin_R().transpose().to_owned()
}
