//! State-space models at design time.

use faer::{Mat, MatRef, c64};
use fd_core::{Shape, ShapeError};

use crate::{
    domain::TimeDomain,
    error::ModelError,
    linalg::{eigenvalues, require_decay},
};

/// A linear model `ẋ = A x + B u` (or `x⁺ = …`), `y = C x + D u`.
///
/// # Examples
///
/// A first-order lag with a time constant of 0.5 s, sampled every 50 ms:
///
/// ```
/// use faer::mat;
/// use fd_model::{Continuous, SampleTime, StateSpace};
///
/// let lag = StateSpace::new(mat![[-2.0]], mat![[2.0]], mat![[1.0]], mat![[0.0]], Continuous)?;
/// let sampled = lag.sample_zoh(SampleTime::new(0.05)?)?;
/// assert!((sampled.a()[(0, 0)] - (-0.1_f64).exp()).abs() < 1e-15);
/// # Ok::<(), fd_model::ModelError>(())
/// ```
///
/// A continuous model cannot run; sample it first:
///
/// ```compile_fail,E0599
/// # use faer::mat;
/// # use fd_model::{Continuous, StateSpace};
/// # let lag = StateSpace::new(mat![[-2.0]], mat![[2.0]], mat![[1.0]], mat![[0.0]], Continuous)?;
/// lag.freeze::<f64, fd_core::Heap>()?;
/// # Ok::<(), fd_model::ModelError>(())
/// ```
#[derive(Clone, Debug)]
pub struct StateSpace<D> {
    pub(crate) a: Mat<f64>,
    pub(crate) b: Mat<f64>,
    pub(crate) c: Mat<f64>,
    pub(crate) d: Mat<f64>,
    pub(crate) domain: D,
}

impl<D: TimeDomain> StateSpace<D> {
    /// Checks that the matrices fit together.
    ///
    /// # Errors
    ///
    /// Returns the first matrix of the wrong size or with a NaN or infinity; `A` sets the number
    /// of states, `B` of inputs and `C` of outputs.
    pub fn new(
        a: Mat<f64>,
        b: Mat<f64>,
        c: Mat<f64>,
        d: Mat<f64>,
        domain: D,
    ) -> Result<Self, ModelError> {
        let (nx, nu, ny) = (a.nrows(), b.ncols(), c.nrows());
        let roles = [
            ("state matrix A", a.as_ref(), Shape::new(nx, nx)),
            ("input matrix B", b.as_ref(), Shape::new(nx, nu)),
            ("output matrix C", c.as_ref(), Shape::new(ny, nx)),
            ("feedthrough D", d.as_ref(), Shape::new(ny, nu)),
        ];
        for (role, matrix, expected) in roles {
            check_matrix(role, matrix, expected)?;
        }
        Ok(Self { a, b, c, d, domain })
    }

    /// State matrix.
    pub fn a(&self) -> MatRef<'_, f64> {
        self.a.as_ref()
    }

    /// Input matrix.
    pub fn b(&self) -> MatRef<'_, f64> {
        self.b.as_ref()
    }

    /// Output matrix.
    pub fn c(&self) -> MatRef<'_, f64> {
        self.c.as_ref()
    }

    /// Feedthrough matrix.
    pub fn d(&self) -> MatRef<'_, f64> {
        self.d.as_ref()
    }

    /// Time axis.
    pub fn domain(&self) -> D {
        self.domain
    }

    /// Number of states.
    pub fn nx(&self) -> usize {
        self.a.nrows()
    }

    /// Number of inputs.
    pub fn nu(&self) -> usize {
        self.b.ncols()
    }

    /// Number of outputs.
    pub fn ny(&self) -> usize {
        self.c.nrows()
    }

    /// Eigenvalues of `A`, in 1/s for continuous and per sample for discrete models.
    ///
    /// # Errors
    ///
    /// Returns an error when the iteration does not converge.
    pub fn poles(&self) -> Result<Vec<c64>, ModelError> {
        eigenvalues(self.a())
    }

    /// The eigenvalue that is closest to instability, or deepest in it; `None` without states.
    ///
    /// # Errors
    ///
    /// Returns an error when the eigenvalues do not converge.
    pub fn worst_pole(&self) -> Result<Option<c64>, ModelError> {
        let poles = self.poles()?;
        Ok(poles
            .into_iter()
            .min_by(|p, q| self.domain.margin(*p).total_cmp(&self.domain.margin(*q))))
    }

    /// Eigenvalues of `A`, all of which have to decay for `what` to make sense.
    ///
    /// # Errors
    ///
    /// Returns the worst eigenvalue when it does not decay.
    pub(crate) fn stable_poles(&self, what: &'static str) -> Result<Vec<c64>, ModelError> {
        let poles = self.poles()?;
        require_decay(what, &poles, |pole| self.domain.margin(pole))?;
        Ok(poles)
    }

    /// Whether every mode dies out.
    ///
    /// # Errors
    ///
    /// Returns an error when the eigenvalues do not converge.
    pub fn is_stable(&self) -> Result<bool, ModelError> {
        Ok(self.poles()?.into_iter().all(|pole| self.domain.decays(pole)))
    }
}

/// Checks the size of a matrix, and that each entry is a number.
pub(crate) fn check_matrix(
    role: &'static str,
    matrix: MatRef<'_, f64>,
    expected: Shape,
) -> Result<(), ModelError> {
    let found = Shape::new(matrix.nrows(), matrix.ncols());
    if found != expected {
        return Err(ShapeError { role, expected, found }.into());
    }
    for col in 0..matrix.ncols() {
        for row in 0..matrix.nrows() {
            let value = matrix[(row, col)];
            if !value.is_finite() {
                return Err(ModelError::NonFinite { role, row, col, value });
            }
        }
    }
    Ok(())
}
