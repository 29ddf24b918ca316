//! Lyapunov and Sylvester equations.

use faer::{Mat, MatRef, c64};
use fd_core::Shape;

use crate::{
    domain::unit_disk_margin,
    error::ModelError,
    linalg::{self, Cayley, RealSchur, Stein, balance, eigenvalues, require_decay, symmetric},
    state_space::check_matrix,
};

/// Solves `A X + X Aᵀ + Q = 0` for a symmetric `Q` and an `A` with all eigenvalues in the left
/// half-plane.
///
/// The solution is the covariance of `ẋ = A x + w` under white noise of intensity `Q`. Squared
/// Smith iteration (Smith 1968) on the Cayley transform of `A`, in balanced coordinates and with
/// iterative refinement, so that all work is products of matrices: the residual ends near
/// `n ε (‖A‖ ‖X‖ + ‖Q‖)`.
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
    if n == 0 {
        return Ok(Mat::zeros(0, 0));
    }
    let scaling = balance(a, q, Mat::zeros(0, n).as_ref());
    let scaled = scaling.a(a);
    let steps = || {
        let transform = Cayley::new(scaled.as_ref()).ok()?;
        Some((Stein::new(transform.a())?, transform))
    };
    let what = "the continuous Lyapunov equation";
    let (stein, transform) = steps().ok_or_else(|| unsolvable(what, a, |pole| -pole.re))?;

    // Units act on both sides of a covariance, and so does the transform.
    let q = scaling.b(scaling.b(symmetric(q).as_ref()).transpose());
    let solve = |q: &Mat<f64>| stein.solve(transform.b(transform.b(q.as_ref()).transpose()));
    let residual = |x: &Mat<f64>| {
        let moved = &scaled * x;
        &q + &moved + moved.transpose()
    };
    let x = refined(&q, scaled.norm_l2(), solve, residual)
        .ok_or(ModelError::NoConvergence { what, order: n })?;
    Ok(scaling.undo_b(scaling.undo_b(x.as_ref()).transpose()))
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
    let scaling = balance(a, q, Mat::zeros(0, n).as_ref());
    let scaled = scaling.a(a);
    let what = "the discrete Lyapunov equation";
    let stein = Stein::new(scaled.clone()).ok_or_else(|| unsolvable(what, a, unit_disk_margin))?;

    // Units act on both sides of a covariance.
    let q = scaling.b(scaling.b(symmetric(q).as_ref()).transpose());
    let solve = |q: &Mat<f64>| stein.solve(q.clone());
    let residual = |x: &Mat<f64>| &q + &scaled * x * scaled.transpose() - x;
    let x = refined(&q, 1.0 + scaled.norm_l2().powi(2), solve, residual)
        .ok_or(ModelError::NoConvergence { what, order: n })?;
    Ok(scaling.undo_b(scaling.undo_b(x.as_ref()).transpose()))
}

/// Why a Lyapunov equation has no solution.
fn unsolvable(what: &'static str, a: MatRef<'_, f64>, margin: impl Fn(c64) -> f64) -> ModelError {
    let verdict = eigenvalues(a).and_then(|poles| require_decay(what, &poles, margin));
    verdict.err().unwrap_or(ModelError::NoConvergence { what, order: a.nrows() })
}

/// Solves a linear equation for a symmetric `X` by a method that leaves a small share of the
/// right-hand side, until the residual is that of rounding or refinement does not halve it.
///
/// `size` is about the norm of the operator.
fn refined(
    q: &Mat<f64>,
    size: f64,
    solve: impl Fn(&Mat<f64>) -> Mat<f64>,
    residual: impl Fn(&Mat<f64>) -> Mat<f64>,
) -> Option<Mat<f64>> {
    let mut x = symmetric(solve(q).as_ref());
    let mut error = residual(&x);
    loop {
        let rounding = f64::EPSILON * (size * x.norm_l2() + q.norm_l2());
        // Comparisons with a NaN are false.
        if error.norm_l2() <= rounding {
            return Some(x);
        }
        let refined = symmetric((&x + solve(&error)).as_ref());
        let left = residual(&refined);
        if !left.norm_l2().is_finite() {
            return None;
        }
        if error.norm_l2() <= 2.0 * left.norm_l2() {
            return Some(x);
        }
        (x, error) = (refined, left);
    }
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
