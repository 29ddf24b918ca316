//! Frequency response and steady-state gain.

use faer::{Mat, MatRef, c64, prelude::Solve};
use fd_numeric::dense::Dense;

use crate::{
    domain::TimeDomain,
    error::ModelError,
    linalg::{identity_minus, solve},
    state_space::StateSpace,
};

impl<D: TimeDomain> StateSpace<D> {
    /// The transfer matrix at `omega` rad/s: `D + C (s I − A)⁻¹ B` with `s = jω` in continuous
    /// and `e^{jωTs}` in discrete time.
    ///
    /// # Errors
    ///
    /// Returns an error when there is a pole at this frequency.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_model::{Continuous, StateSpace};
    ///
    /// let lag = StateSpace::new(mat![[-2.0]], mat![[2.0]], mat![[1.0]], mat![[0.0]], Continuous)?;
    /// let corner = lag.frequency_response(2.0)?[(0, 0)];
    /// assert!((corner.norm() - 0.5_f64.sqrt()).abs() < 1e-15);
    /// # Ok::<(), fd_model::ModelError>(())
    /// ```
    pub fn frequency_response(&self, omega: f64) -> Result<Mat<c64>, ModelError> {
        if omega.is_infinite() {
            return Ok(complex(self.d()));
        }
        self.transfer_at(self.domain().point(omega))
    }

    /// The transfer matrix `D + C (p I − A)⁻¹ B` at any point `p` of the complex plane.
    ///
    /// # Errors
    ///
    /// Returns an error when the point is a pole.
    pub fn transfer_at(&self, point: c64) -> Result<Mat<c64>, ModelError> {
        let n = self.nx();
        if n == 0 {
            return Ok(complex(self.d()));
        }
        let resolvent = Mat::from_fn(n, n, |i, j| {
            let a = c64::new(self.a()[(i, j)], 0.0);
            if i == j { point - a } else { -a }
        });
        let x = resolvent.lu().solve(complex(self.b()));
        let response = complex(self.c()) * x + complex(self.d());
        let finite = (0..response.ncols()).all(|j| response.col(j).iter().all(|g| g.is_finite()));
        if finite {
            Ok(response)
        } else {
            Err(ModelError::Singular { role: "the resolvent sI − A" })
        }
    }

    /// The gain from constant inputs to the outputs they lead to.
    ///
    /// # Errors
    ///
    /// Returns an error when there is a pole at `s = 0` or `z = 1`.
    pub fn dc_gain(&self) -> Result<Mat<f64>, ModelError> {
        let resolvent = identity_minus(self.domain().steady_point(), self.a());
        let x = solve("the steady-state matrix (A, or I − A)", resolvent.as_ref(), self.b())?;
        Ok(self.d() + self.c() * x)
    }
}

fn complex(matrix: MatRef<'_, f64>) -> Mat<c64> {
    Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| c64::new(matrix[(i, j)], 0.0))
}
