//! Algebraic Riccati equations of optimal control and of the steady-state Kalman filter.
//!
//! | problem | equation | here |
//! |---------|----------|------|
//! | regulator, discrete | `P = AᵀPA − AᵀPB (R + BᵀPB)⁻¹ BᵀPA + Q` | [`discrete_regulator`] |
//! | filter, discrete | `P = APAᵀ − APCᵀ (R + CPCᵀ)⁻¹ CPAᵀ + Q` | [`discrete_filter`] |
//!
//! Both by the structure-preserving doubling algorithm (E. K.-W. Chu, H.-Y. Fan, W.-W. Lin and
//! C.-S. Wang, "Structure-preserving algorithms for periodic discrete-time algebraic Riccati
//! equations", Int. J. Control 77(8), 2004): quadratic convergence, no reordered Schur form.
//! The pair must be stabilisable (detectable for the filter), with no closed-loop eigenvalue on
//! the unit circle. Modes of `A` that `Q` does not see may be unstable: the stabilising solution
//! then moves them to their mirror images in the unit circle, and is not the smallest solution, to
//! which doubling converges. Newton's method (Kleinman 1968, Hewer 1971) is then started from the
//! solution for a larger `Q`.

use faer::{Mat, MatRef, Scale, prelude::Solve};
use fd_core::Shape;
use fd_numeric::dense::Dense;

use crate::{
    domain::unit_disk_margin,
    error::ModelError,
    linalg::{balance, eigenvalues, is_positive, require_decay, solve, symmetric},
    lyapunov,
    state_space::check_matrix,
};

/// Stabilising solution of a discrete Riccati equation.
#[derive(Clone, Debug)]
pub struct DiscreteRiccati {
    /// Solution `P`, symmetric positive semidefinite. For the filter: covariance of the error of
    /// the one-step prediction.
    pub p: Mat<f64>,
    /// Regulator: `K = (R + BᵀPB)⁻¹ BᵀPA`, with `A − B K` stable. Filter: the predictor gain
    /// `L = A P Cᵀ (R + CPCᵀ)⁻¹`, with `A − L C` stable.
    pub gain: Mat<f64>,
    /// Regulator: `R + BᵀPB`. Filter: the covariance `R + CPCᵀ` of the innovations.
    pub weight: Mat<f64>,
}

/// The regulator that minimises `Σ xᵀQx + uᵀRu` for `x⁺ = A x + B u`.
///
/// # Errors
///
/// Returns an error when sizes do not fit, `Q` is not symmetric positive semidefinite or `R` not
/// definite, or no stabilising solution exists: [`ModelError::NotStabilisable`] names the
/// eigenvalue that stays outside of the unit circle or, for a mode that `Q` does not see, on it.
///
/// # Examples
///
/// ```
/// use faer::mat;
/// use fd_model::riccati;
///
/// // p² = p + 1 for a = b = q = r = 1: the golden ratio.
/// let one = mat![[1.0]];
/// let regulator =
///     riccati::discrete_regulator(one.as_ref(), one.as_ref(), one.as_ref(), one.as_ref())?;
/// assert!((regulator.p[(0, 0)] - 0.5 * (1.0 + 5.0_f64.sqrt())).abs() < 1e-15);
/// # Ok::<(), fd_model::ModelError>(())
/// ```
pub fn discrete_regulator(
    a: MatRef<'_, f64>,
    b: MatRef<'_, f64>,
    q: MatRef<'_, f64>,
    r: MatRef<'_, f64>,
) -> Result<DiscreteRiccati, ModelError> {
    let (n, m) = (a.nrows(), b.ncols());
    let roles = [
        ("state matrix A", a, Shape::new(n, n)),
        ("input matrix B", b, Shape::new(n, m)),
        ("state weight Q", q, Shape::new(n, n)),
        ("input weight R", r, Shape::new(m, m)),
    ];
    solve_regulator("the discrete regulator", &roles)
}

/// The steady-state Kalman filter of `x⁺ = A x + w`, `y = C x + v` with `cov w = Q`, `cov v = R`
/// and `w`, `v` independent.
///
/// `Q` may be zero: stable modes are then not filtered at all, and the filter follows an unstable
/// mode `λ` with one of `1/λ`.
///
/// # Errors
///
/// Returns an error when sizes do not fit, `Q` is not symmetric positive semidefinite or `R` not
/// definite, or no stabilising solution exists: [`ModelError::NotStabilisable`] names the
/// eigenvalue that stays outside of the unit circle or, for a mode that `Q` does not see, on it.
///
/// # Examples
///
/// ```
/// use faer::mat;
/// use fd_model::riccati;
///
/// let one = mat![[1.0]];
/// let filter = riccati::discrete_filter(one.as_ref(), one.as_ref(), one.as_ref(), one.as_ref())?;
/// assert!((filter.weight[(0, 0)] - (1.0 + filter.p[(0, 0)])).abs() < 1e-15);
/// # Ok::<(), fd_model::ModelError>(())
/// ```
pub fn discrete_filter(
    a: MatRef<'_, f64>,
    c: MatRef<'_, f64>,
    q: MatRef<'_, f64>,
    r: MatRef<'_, f64>,
) -> Result<DiscreteRiccati, ModelError> {
    let (n, p) = (a.nrows(), c.nrows());
    // The filter is the regulator of the transposed system.
    let roles = [
        ("state matrix A", a.transpose(), Shape::new(n, n)),
        ("output matrix C, transposed", c.transpose(), Shape::new(n, p)),
        ("process noise covariance Q", q, Shape::new(n, n)),
        ("measurement noise covariance R", r, Shape::new(p, p)),
    ];
    let dual = solve_regulator("the discrete filter", &roles)?;
    Ok(DiscreteRiccati { gain: dual.gain.transpose().to_owned(), ..dual })
}

type Role<'a> = (&'static str, MatRef<'a, f64>, Shape);

fn solve_regulator(
    what: &'static str,
    roles: &[Role<'_>; 4],
) -> Result<DiscreteRiccati, ModelError> {
    for &(role, matrix, expected) in roles {
        check_matrix(role, matrix, expected)?;
    }
    let &[(_, a, _), (_, b, _), (q_role, q, _), (r_role, r, _)] = roles;
    if !is_positive(q, 0.0)? {
        return Err(ModelError::NotPositive { role: q_role, needed: "semidefinite" });
    }
    if !is_positive(r, f64::EPSILON)? {
        return Err(ModelError::NotPositive { role: r_role, needed: "definite" });
    }

    let scaling = balance(a, b, q);
    let problem = Problem {
        a: scaling.a(a),
        b: scaling.b(b),
        q: scaling.c(scaling.c(symmetric(q).as_ref()).transpose()),
        r: symmetric(r),
        r_role,
    };
    let g = &problem.b * solve(r_role, r, problem.b.transpose())?;
    let g = symmetric(g.as_ref());
    let doubled = |weight: Mat<f64>| {
        double(&problem.a, g.clone(), weight)
            .ok_or(ModelError::NoConvergence { what, order: a.nrows() })
    };
    let finish = |p: Mat<f64>, edge: f64| {
        let p = problem.refine(p)?;
        let p = scaling.undo_c(scaling.undo_c(p.as_ref()).transpose());
        let weight = r + b.transpose() * &p * b;
        let gain = solve(r_role, weight.as_ref(), (b.transpose() * &p * a).as_ref())?;

        let closed = a - b * &gain;
        let margin = |eigenvalue| unit_disk_margin(eigenvalue) - edge;
        require_decay(what, &eigenvalues(closed.as_ref())?, margin).map_err(not_stabilisable)?;
        Ok(DiscreteRiccati { p, gain, weight })
    };
    let smallest = doubled(problem.q.clone()).and_then(|p| finish(p, 0.0));
    smallest.or_else(|error| {
        let n = a.nrows();
        // In units of a solution that moves an unstable mode.
        let more = Scale(g.norm_l2().max(f64::MIN_POSITIVE).recip());
        doubled(&problem.q + more * Mat::<f64>::identity(n, n))
            .and_then(|p| finish(problem.descend(p)?, EDGE))
            .map_err(|_| error)
    })
}

/// A pair of eigenvalues on the unit circle moves by `√ε` of a perturbation of `ε`, so that one
/// this close cannot be told from one that stays on it.
const EDGE: f64 = 1.5e-8;

fn not_stabilisable(error: ModelError) -> ModelError {
    match error {
        ModelError::Unstable { what, re, im } => ModelError::NotStabilisable { what, re, im },
        other => other,
    }
}

/// The regulator problem in balanced coordinates.
struct Problem {
    a: Mat<f64>,
    b: Mat<f64>,
    q: Mat<f64>,
    r: Mat<f64>,
    r_role: &'static str,
}

impl Problem {
    /// Newton's method from a solution that stabilises the loop for a larger weight: falls to the
    /// largest solution, every loop on the way being stable.
    fn descend(&self, mut p: Mat<f64>) -> Result<Mat<f64>, ModelError> {
        // Halves what is left at least, so that these span the range of a number; then quadratic.
        const STEPS: usize = 100;
        const NEARLY: f64 = 1e-4;

        for _ in 0..STEPS {
            let (closed, residual) = self.closed_loop(&p)?;
            let step = lyapunov::discrete(closed.transpose(), residual.as_ref())?;
            p += &step;
            if step.norm_l2() <= NEARLY * p.norm_l2() {
                break;
            }
        }
        Ok(p)
    }

    /// Newton's method (Hewer 1971) from a solution that is nearly right, for as long as it
    /// halves the residual.
    fn refine(&self, mut p: Mat<f64>) -> Result<Mat<f64>, ModelError> {
        let (mut closed, mut residual) = self.closed_loop(&p)?;
        // Without a stable loop there is no Newton step; the caller says what that means.
        while let Ok(step) = lyapunov::discrete(closed.transpose(), residual.as_ref()) {
            let next = &p + step;
            let (next_closed, next_residual) = self.closed_loop(&next)?;
            if residual.norm_l2() <= 2.0 * next_residual.norm_l2() {
                break;
            }
            (p, closed, residual) = (next, next_closed, next_residual);
        }
        Ok(p)
    }

    /// `A − BK`, and the residual `Q + AᵀP(A − BK) − P`.
    fn closed_loop(&self, p: &Mat<f64>) -> Result<(Mat<f64>, Mat<f64>), ModelError> {
        let bp = self.b.transpose() * p;
        let weight = &self.r + &bp * &self.b;
        let gain = solve(self.r_role, weight.as_ref(), (bp * &self.a).as_ref())?;
        let closed = &self.a - &self.b * gain;
        let residual = &self.q + self.a.transpose() * p * &closed - p;
        Ok((closed, symmetric(residual.as_ref())))
    }
}

/// Doubling of `P = AᵀP(I + GP)⁻¹A + H`; after `k` steps `H` is the solution over a horizon of
/// `2ᵏ` samples, and `A` the closed-loop transition over it.
fn double(a: &Mat<f64>, mut g: Mat<f64>, mut h: Mat<f64>) -> Option<Mat<f64>> {
    const DOUBLINGS: usize = 64;

    let n = a.nrows();
    let mut a = a.clone();
    if n == 0 {
        return Some(h);
    }
    for _ in 0..DOUBLINGS {
        let lu = (Mat::<f64>::identity(n, n) + &g * &h).lu();
        let wa = lu.solve(&a);
        let wg = lu.solve(&g);
        let step = a.transpose() * &h * &wa;
        g += &a * wg * a.transpose();
        a = &a * wa;
        h += &step;
        (g, h) = (symmetric(g.as_ref()), symmetric(h.as_ref()));
        if !h.norm_l2().is_finite() || !g.norm_l2().is_finite() {
            return None;
        }
        if step.norm_l2() <= f64::EPSILON * h.norm_l2() {
            return Some(h);
        }
    }
    None
}
