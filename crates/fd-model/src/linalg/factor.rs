//! Factors of gramians by doubling.

use faer::{Mat, MatRef, concat};

use crate::error::ModelError;

/// Factors of the gramians of a stable discrete system `(A, B, C)`: `L_c L_cᵀ = P` with
/// `A P Aᵀ − P + B Bᵀ = 0`, and `L_o L_oᵀ = Q` with `Aᵀ Q A − Q + Cᵀ C = 0`.
///
/// Squared Smith iteration (Smith 1968) on the factors: `L ← [L, A L]`, `A ← A²`, with an
/// orthogonal compression to at most as many columns as states. The powers serve both gramians.
/// Neither gramian is formed, so that small Hankel values survive as they do in Hammarling's
/// method; and all work is products and QR factorisations of large blocks.
///
/// # Errors
///
/// Returns an error when `A` is too close to instability to converge.
pub(crate) fn smith_factors([a, b, c]: [Mat<f64>; 3]) -> Result<[Mat<f64>; 2], ModelError> {
    // 2⁶⁴ steps: only an eigenvalue that is on the unit circle to rounding needs more.
    const DOUBLINGS: usize = 64;

    let order = a.nrows();
    let mut power = a;
    let (mut l_c, mut l_o) = (Some(b), Some(c.transpose().to_owned()));
    let (mut controllability, mut observability) = (None, None);
    for _ in 0..DOUBLINGS {
        if let Some(factor) = l_c.take() {
            match doubled(&factor, &(&power * &factor)) {
                Step::Converged => controllability = Some(factor),
                Step::Goes(factor) => l_c = Some(factor),
                Step::Diverged => break,
            }
        }
        if let Some(factor) = l_o.take() {
            match doubled(&factor, &(power.transpose() * &factor)) {
                Step::Converged => observability = Some(factor),
                Step::Goes(factor) => l_o = Some(factor),
                Step::Diverged => break,
            }
        }
        if let (Some(_), Some(_)) = (&controllability, &observability) {
            break;
        }
        power = &power * &power;
    }
    match (controllability, observability) {
        (Some(l_c), Some(l_o)) => Ok([l_c, l_o]),
        _ => Err(ModelError::NoConvergence { what: "the gramian", order }),
    }
}

/// What a doubling has come to.
enum Step {
    Converged,
    Goes(Mat<f64>),
    Diverged,
}

/// The factor with what it has moved to, `[L, A L]`.
fn doubled(factor: &Mat<f64>, moved: &Mat<f64>) -> Step {
    let (step, size) = (moved.norm_l2(), factor.norm_l2());
    if !size.is_finite() || !step.is_finite() {
        Step::Diverged
    } else if step <= f64::EPSILON * size {
        Step::Converged
    } else {
        Step::Goes(compress(concat![[factor, moved]].as_ref()))
    }
}

/// A factor of the same product with at most as many columns as rows.
fn compress(factor: MatRef<'_, f64>) -> Mat<f64> {
    if factor.ncols() <= factor.nrows() {
        return factor.to_owned();
    }
    factor.transpose().qr().thin_R().transpose().to_owned()
}
