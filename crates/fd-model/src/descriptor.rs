//! Models with algebraic equations among their differential ones: `E ẋ = A x + B u`.
//!
//! * **Equation.** `E ẋ = A x + B u`, `y = C x + D u` (or `E x⁺ = …`), `E` square and usually singular: balances,
//!   constraints and connections as they come out of modelling.
//! * **What is done.** With `Uᵀ E V = diag(Σ, 0)` and `Uᵀ A V` in blocks of the same sizes, a model of index one has
//!   an invertible `A₂₂`; then `x₂ = −A₂₂⁻¹ (A₂₁ x₁ + B₂ u)` and what is left is a [`StateSpace`] with the states `x₁`.
//!   The null space of a residual generator, its poles and its norms are those of this system.
//! * **Source.** E. L. Yip and R. F. Sincovec, "Solvability, controllability, and observability of continuous descriptor
//!   systems", IEEE TAC 26(3), 1981; L. Dai, "Singular Control Systems", Springer, 1989, section 1.2.
//! * **Do not use** it for models of a higher index (two rigidly coupled masses with a state each, an ideal pump that
//!   sets a level): their outputs may contain derivatives of the inputs. They are refused, with the equation that
//!   shows it; eliminate the doubled states by hand, or differentiate the constraint.

use faer::{Mat, MatRef};
use fd_core::Shape;

use crate::{
    domain::TimeDomain,
    error::ModelError,
    linalg::{singular_values, solve, svd},
    state_space::{StateSpace, check_matrix},
};

/// Relative singular values below this count as zero: ten digits, as ranks elsewhere.
const RANK: f64 = 1e-10;

/// A linear model whose state equations need not be solved for the rates.
///
/// # Examples
///
/// A tank that drains through a pipe; the flow `q` in the pipe has an equation of its own:
///
/// ```
/// use faer::mat;
/// use fd_model::{Continuous, DescriptorSystem};
///
/// // ḣ = u − q and 0 = h − 2 q, measured is q.
/// let e = mat![[1.0, 0.0], [0.0, 0.0]];
/// let a = mat![[0.0, -1.0], [1.0, -2.0]];
/// let (b, c) = (mat![[1.0], [0.0]], mat![[0.0, 1.0]]);
/// let tank = DescriptorSystem::new(e, a, b, c, mat![[0.0]], Continuous)?;
/// let system = tank.to_state_space()?;
/// assert_eq!(system.nx(), 1);
/// assert!((system.poles()?[0].re + 0.5).abs() < 1e-15);
/// assert!((system.dc_gain()?[(0, 0)] - 1.0).abs() < 1e-15);
/// # Ok::<(), fd_model::ModelError>(())
/// ```
#[derive(Clone, Debug)]
pub struct DescriptorSystem<D> {
    e: Mat<f64>,
    a: Mat<f64>,
    b: Mat<f64>,
    c: Mat<f64>,
    d: Mat<f64>,
    domain: D,
}

impl<D: TimeDomain> DescriptorSystem<D> {
    /// Checks that the matrices fit together.
    ///
    /// # Errors
    ///
    /// Returns the first matrix of the wrong size or with a NaN or infinity.
    pub fn new(
        e: Mat<f64>,
        a: Mat<f64>,
        b: Mat<f64>,
        c: Mat<f64>,
        d: Mat<f64>,
        domain: D,
    ) -> Result<Self, ModelError> {
        let (nx, nu, ny) = (a.nrows(), b.ncols(), c.nrows());
        let roles = [
            ("descriptor matrix E", e.as_ref(), Shape::new(nx, nx)),
            ("state matrix A", a.as_ref(), Shape::new(nx, nx)),
            ("input matrix B", b.as_ref(), Shape::new(nx, nu)),
            ("output matrix C", c.as_ref(), Shape::new(ny, nx)),
            ("feedthrough D", d.as_ref(), Shape::new(ny, nu)),
        ];
        for (role, matrix, expected) in roles {
            check_matrix(role, matrix, expected)?;
        }
        Ok(Self { e, a, b, c, d, domain })
    }

    /// The descriptor matrix `E`.
    pub fn e(&self) -> MatRef<'_, f64> {
        self.e.as_ref()
    }

    /// The state matrix `A`.
    pub fn a(&self) -> MatRef<'_, f64> {
        self.a.as_ref()
    }

    /// The same transfer function with as many states as `E` has rank; all inputs and outputs stay, so faults and
    /// disturbances may be columns of `B` and `D` like others.
    ///
    /// # Errors
    ///
    /// Returns [`ModelError::HighIndex`] for a model of index two or more, and [`ModelError::Singular`] when
    /// `det(sE − A)` vanishes for all `s`, so that there is no solution or more than one.
    ///
    /// # Examples
    ///
    /// Two masses that a rigid rod joins have one velocity, not two:
    ///
    /// ```
    /// use faer::mat;
    /// use fd_model::{Continuous, DescriptorSystem, ModelError};
    ///
    /// // v̇₁ = u − f, v̇₂ = f, 0 = v₁ − v₂
    /// let e = mat![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]];
    /// let a = mat![[0.0, 0.0, -1.0], [0.0, 0.0, 1.0], [1.0, -1.0, 0.0]];
    /// let (b, c) = (mat![[1.0], [0.0], [0.0]], mat![[1.0, 0.0, 0.0]]);
    /// let rod = DescriptorSystem::new(e, a, b, c, mat![[0.0]], Continuous)?;
    /// assert!(matches!(rod.to_state_space(), Err(ModelError::HighIndex { algebraic: 1, solved: 0 })));
    /// # Ok::<(), ModelError>(())
    /// ```
    pub fn to_state_space(&self) -> Result<StateSpace<D>, ModelError> {
        let n = self.a.nrows();
        let (rows, columns) = self.units();
        let scaled = |m: &Mat<f64>| {
            Mat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] * rows[i] * columns[j])
        };
        let (e, a) = (scaled(&self.e), scaled(&self.a));
        let b = Mat::from_fn(n, self.b.ncols(), |i, j| self.b[(i, j)] * rows[i]);
        let c = Mat::from_fn(self.c.nrows(), n, |i, j| self.c[(i, j)] * columns[j]);

        let (u, values, v) = full_svd(&e)?;
        let largest = values.first().copied().unwrap_or(0.0);
        let rank = values.iter().filter(|&&s| RANK * largest < s && 0.0 < s).count();
        let (a, b, c) = (u.transpose() * a * &v, u.transpose() * b, c * &v);
        let rest = n - rank;
        let block = |i, j, h, w| a.submatrix(i, j, h, w);
        let a22 = block(rank, rank, rest, rest);
        let algebraic = singular_values(a22)?;
        let size = a.subrows(rank, rest).norm_l2();
        let solved = algebraic.iter().filter(|&&s| RANK * size < s && 0.0 < s).count();
        if solved < rest {
            return Err(if self.is_regular()? {
                ModelError::HighIndex { algebraic: rest, solved }
            } else {
                ModelError::Singular { role: "the pencil sE − A for every s" }
            });
        }
        // x₂ = X [x₁; u]
        let (a21, b2) = (block(rank, 0, rest, rank), b.subrows(rank, rest));
        let role = "the algebraic part A₂₂";
        let (from_x, from_u) = (solve(role, a22, a21)?, solve(role, a22, b2)?);
        let (a12, c2) = (block(0, rank, rank, rest), c.subcols(rank, rest));
        let rates = |m: Mat<f64>| Mat::from_fn(rank, m.ncols(), |i, j| m[(i, j)] / values[i]);
        StateSpace::new(
            rates(block(0, 0, rank, rank) - a12 * &from_x),
            rates(b.subrows(0, rank) - a12 * &from_u),
            c.subcols(0, rank) - c2 * &from_x,
            &self.d - c2 * &from_u,
            self.domain,
        )
    }

    /// Factors for rows and columns that make the entries of `[E, A]` alike: equations and states have units of
    /// their own, and ranks should not depend on them (Ruiz 2001).
    fn units(&self) -> (Vec<f64>, Vec<f64>) {
        const ROUNDS: usize = 8;
        let n = self.a.nrows();
        // E over a rate is like A.
        let or_one = |size: f64| if 0.0 < size { size } else { 1.0 };
        let rate = or_one(self.a.norm_l2()) / or_one(self.e.norm_l2());
        let (mut rows, mut columns) = (vec![1.0_f64; n], vec![1.0_f64; n]);
        for _ in 0..ROUNDS {
            let size = |i: usize, j: usize| {
                (rate * self.e[(i, j)]).abs().max(self.a[(i, j)].abs()) * rows[i] * columns[j]
            };
            let largest = |of: &dyn Fn(usize) -> f64| or_one((0..n).map(of).fold(0.0, f64::max));
            let by_row: Vec<f64> = (0..n).map(|i| largest(&|j| size(i, j))).collect();
            let by_column: Vec<f64> = (0..n).map(|j| largest(&|i| size(i, j))).collect();
            for k in 0..n {
                rows[k] /= by_row[k].sqrt();
                columns[k] /= by_column[k].sqrt();
            }
        }
        (rows, columns)
    }

    /// Whether `sE − A` is invertible for some `s`, tried at a few.
    fn is_regular(&self) -> Result<bool, ModelError> {
        let (rows, columns) = self.units();
        let n = self.a.nrows();
        let or_one = |size: f64| if 0.0 < size { size } else { 1.0 };
        let rate = or_one(self.a.norm_l2()) / or_one(self.e.norm_l2());
        for s in [0.37, -0.73, 1.91] {
            let at = Mat::from_fn(n, n, |i, j| {
                (s * rate * self.e[(i, j)] - self.a[(i, j)]) * rows[i] * columns[j]
            });
            let values = singular_values(at.as_ref())?;
            let (first, last) = (values.first().copied(), values.last().copied());
            if first.zip(last).is_some_and(|(first, last)| RANK * first < last) {
                return Ok(true);
            }
        }
        Ok(n == 0)
    }
}

/// `U`, the values and `V` of `E = U diag(values) Vᵀ`.
type FullSvd = (Mat<f64>, Vec<f64>, Mat<f64>);

/// `E = U diag(values) Vᵀ` with square `U` and `V`.
fn full_svd(e: &Mat<f64>) -> Result<FullSvd, ModelError> {
    // A square matrix has as many values as rows.
    let parts = svd(e.as_ref())?;
    Ok((parts.u, parts.values, parts.v))
}
