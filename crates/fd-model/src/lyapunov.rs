//! Lyapunov and Sylvester equations.

use faer::{Mat, MatRef};
use fd_core::Shape;

use crate::{
    domain::unit_disk_margin,
    error::ModelError,
    linalg::{self, RealSchur, balance, eigenvalues, require_decay, symmetric},
    state_space::check_matrix,
};

/// Solves `A X + X Aᵀ + Q = 0` for a symmetric `Q` and an `A` with all eigenvalues in the left
/// half-plane.
///
/// The solution is the covariance of `ẋ = A x + w` under white noise of intensity `Q`. Bartels
/// and Stewart's method in balanced coordinates: the residual is near `n ε ‖A‖ ‖X‖`.
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
/// // p = q / 2a
/// let p = lyapunov::continuous(mat![[-2.0]].as_ref(), mat![[3.0]].as_ref())?;
/// assert!((p[(0, 0)] - 0.75).abs() < 1e-15);
/// # Ok::<(), fd_model::ModelError>(())
/// ```
pub fn continuous(a: MatRef<'_, f64>, q: MatRef<'_, f64>) -> Result<Mat<f64>, ModelError> {
    let n = a.nrows();
    check_shapes([("state matrix A", a, n, n), ("weight Q", q, n, n)])?;
    require_decay("the continuous Lyapunov equation", &eigenvalues(a)?, |pole| -pole.re)?;

    let scaling = balance(a, q, Mat::zeros(0, n).as_ref());
    let schur = RealSchur::new(scaling.a(a).as_ref())?;
    // Units act on both sides of a covariance.
    let q = scaling.b(scaling.b(symmetric(q).as_ref()).transpose());
    let x = linalg::sylvester(&schur, &schur.transposed(), (-q).as_ref())?;
    Ok(scaling.undo_b(scaling.undo_b(symmetric(x.as_ref()).as_ref()).transpose()))
}

/// Solves the Sylvester equation `A X + X B = C` for square `A` and `B` of any stability.
///
/// # Errors
///
/// Returns an error when the sizes do not fit, or an eigenvalue of `A` is the negative of one of
/// `B`, so that there is no unique solution.
///
/// # Examples
///
/// ```
/// use faer::mat;
/// use fd_model::lyapunov;
///
/// let (a, b, c) = (mat![[3.0]], mat![[-1.0]], mat![[4.0]]);
/// let x = lyapunov::sylvester(a.as_ref(), b.as_ref(), c.as_ref())?;
/// assert!((x[(0, 0)] - 2.0).abs() < 1e-15);
/// # Ok::<(), fd_model::ModelError>(())
/// ```
pub fn sylvester(
    a: MatRef<'_, f64>,
    b: MatRef<'_, f64>,
    c: MatRef<'_, f64>,
) -> Result<Mat<f64>, ModelError> {
    let (n, m) = (a.nrows(), b.nrows());
    check_shapes([
        ("left matrix A", a, n, n),
        ("right matrix B", b, m, m),
        ("right-hand side C", c, n, m),
    ])?;
    linalg::sylvester(&RealSchur::new(a)?, &RealSchur::new(b)?, c)
}

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
    let n = a.nrows();
    check_shapes([("state matrix A", a, n, n), ("weight Q", q, n, n)])?;
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

/// Checks the finite entries and the rows and columns of each matrix.
fn check_shapes<const N: usize>(
    roles: [(&'static str, MatRef<'_, f64>, usize, usize); N],
) -> Result<(), ModelError> {
    for (role, matrix, rows, cols) in roles {
        check_matrix(role, matrix, Shape::new(rows, cols))?;
    }
    Ok(())
}
