//! Lyapunov equations of stable systems.

use faer::{Mat, MatRef};
use fd_core::{Shape, ShapeError};

use crate::{
    domain::unit_disk_margin,
    error::ModelError,
    linalg::{balance, eigenvalues, require_decay, symmetric},
};

/// Solves `A X Aᵀ − X + Q = 0` for a symmetric `Q` and an `A` with all eigenvalues inside the
/// unit circle.
///
/// The solution is the covariance of `x⁺ = A x + w` under white noise of covariance `Q`.
/// Squared Smith iteration (Smith 1968) in balanced coordinates with iterative refinement: the
/// residual ends near `n ε (‖A‖² ‖X‖ + ‖Q‖)`.
///
/// # Errors
///
/// Returns an error when the sizes do not fit, or `A` is not stable (with its worst eigenvalue).
///
/// # Examples
///
/// ```
/// use faer::mat;
/// use fd_model::lyapunov;
///
/// // p = q / (1 − a²)
/// let p = lyapunov::discrete(mat![[0.5]].as_ref(), mat![[3.0]].as_ref())?;
/// assert!((p[(0, 0)] - 4.0).abs() < 1e-15);
/// # Ok::<(), fd_model::ModelError>(())
/// ```
pub fn discrete(a: MatRef<'_, f64>, q: MatRef<'_, f64>) -> Result<Mat<f64>, ModelError> {
    check_shapes(a, q)?;
    let n = a.nrows();
    if n == 0 {
        return Ok(Mat::zeros(0, 0));
    }
    require_decay("the discrete Lyapunov equation", &eigenvalues(a)?, unit_disk_margin)?;

    let scaling = balance(a, q, Mat::zeros(0, n).as_ref());
    let a = scaling.a(a);
    // Units act on both sides of a covariance.
    let q = scaling.b(scaling.b(symmetric(q).as_ref()).transpose());
    let residual = |x: &Mat<f64>| &q + &a * x * a.transpose() - x;

    let mut x = smith(&a, &q)?;
    let mut error = residual(&x);
    loop {
        let refined = &x + smith(&a, &error)?;
        let left = residual(&refined);
        if error.norm_l2() <= 2.0 * left.norm_l2() || left.norm_l2() <= 0.0 {
            let units = scaling.undo_b(scaling.undo_b(symmetric(x.as_ref()).as_ref()).transpose());
            return Ok(units);
        }
        (x, error) = (refined, left);
    }
}

/// The sum `Q + A Q Aᵀ + A² Q A²ᵀ + …` by doubling.
fn smith(a: &Mat<f64>, q: &Mat<f64>) -> Result<Mat<f64>, ModelError> {
    const DOUBLINGS: usize = 64;

    let (mut power, mut x) = (a.clone(), q.clone());
    for _ in 0..DOUBLINGS {
        let step = &power * &x * power.transpose();
        if !step.norm_l2().is_finite() {
            break;
        }
        if step.norm_l2() <= 0.5 * f64::EPSILON * x.norm_l2() {
            return Ok(x);
        }
        x += step;
        power = &power * &power;
    }
    Err(ModelError::NoConvergence { what: "the discrete Lyapunov equation", order: a.nrows() })
}

fn check_shapes(a: MatRef<'_, f64>, q: MatRef<'_, f64>) -> Result<(), ModelError> {
    let n = a.nrows();
    for (role, matrix) in [("state matrix A", a), ("weight Q", q)] {
        let (expected, found) = (Shape::new(n, n), Shape::new(matrix.nrows(), matrix.ncols()));
        if expected != found {
            return Err(ShapeError { role, expected, found }.into());
        }
    }
    Ok(())
}
