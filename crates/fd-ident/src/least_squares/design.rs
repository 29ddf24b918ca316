//! Column-scaled, column-pivoted QR and what it says about the data.

use faer::{ColRef, Mat, MatRef, prelude::SolveLstsq};
use fd_core::{Shape, ShapeError};
use fd_numeric::dense::Dense;

use super::modes::Modes;
use crate::{columns, error::IdentError};

/// What to do with data that do not excite all parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Deficient {
    /// Refuse them with [`IdentError::RankDeficient`].
    #[default]
    Refuse,
    /// Take the shortest of all solutions, in scaled columns; the report says that it is not
    /// unique.
    MinimumNorm,
}

/// A least-squares solver.
///
/// # Examples
///
/// A line through four points:
///
/// ```
/// use faer::mat;
/// use fd_ident::least_squares::LeastSquares;
///
/// let x = mat![[1.0, 0.0], [1.0, 1.0], [1.0, 2.0], [1.0, 3.0]];
/// let fit = LeastSquares::new().solve(x.as_ref(), &[1.0, 3.0, 5.0, 7.0])?;
/// assert!((fit.coefficients[1] - 2.0).abs() < 1e-14);
/// assert_eq!(fit.rank, 2);
/// # Ok::<(), fd_ident::IdentError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LeastSquares {
    deficient: Deficient,
    tolerance: Option<f64>,
}

/// A least-squares solution and how far to trust it.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearFit {
    /// `θ`.
    pub coefficients: Vec<f64>,
    /// `(XᵀX)⁻¹`, or its pseudo-inverse when the rank is deficient.
    pub inverse_gram: Mat<f64>,
    /// Sum of squared residuals `‖y − Xθ‖²`.
    pub rss: f64,
    /// Number of rows.
    pub rows: usize,
    /// Numerical rank of `X`.
    pub rank: usize,
    /// Condition number of `X` after the scaling of its columns.
    pub condition: f64,
}

impl LeastSquares {
    /// A solver that refuses data without enough excitation.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets what to do with data that do not excite all parameters.
    #[must_use]
    pub fn when_deficient(self, deficient: Deficient) -> Self {
        Self { deficient, ..self }
    }

    /// Sets the singular value, relative to the largest, from which on a direction counts as
    /// not excited. The default is `10 n ε`, the rounding of the data themselves and of the
    /// factorisation.
    #[must_use]
    pub fn with_rank_tolerance(self, tolerance: f64) -> Self {
        Self { tolerance: Some(tolerance), ..self }
    }

    /// Whether the rank is decided at the rounding of the data.
    pub(crate) fn has_usual_tolerance(&self) -> bool {
        self.tolerance.is_none()
    }

    /// Solves for one target.
    ///
    /// # Errors
    ///
    /// Returns an error when `X` has other rows than `y` or not more rows than columns, when a
    /// value is not finite, or when the rank is deficient and that is to be refused. The residual
    /// channel in these errors is 0.
    pub fn solve(&self, x: MatRef<'_, f64>, y: &[f64]) -> Result<LinearFit, IdentError> {
        let (rows, n) = (x.nrows(), x.ncols());
        check(x, y)?;
        if x.norm_max() < f64::MIN_POSITIVE {
            return self.solve_silence(n, y);
        }
        let scales: Vec<f64> = (0..n).map(|j| power_of_two(x.col(j).norm_l2())).collect();
        let scaled = columns::scaled(x, &scales);

        let qr = scaled.pivoted_qr();
        let (_, place) = qr.P().arrays();
        let r = qr.thin_R();
        let unpivoted =
            Mat::from_fn(r.nrows(), n, |i, j| if i <= place[j] { r[(i, place[j])] } else { 0.0 });
        // Columns that depend on each other to the last digit can divide by nothing in pivoting.
        let is_sound = unpivoted.norm_max().is_finite();
        let (factor, q) = if is_sound {
            (unpivoted, None)
        } else {
            let plain = scaled.factor_qr();
            (plain.thin_R().to_owned(), Some(plain.compute_thin_Q()))
        };
        let Modes { u, sigma, v } = Modes::of(factor.as_ref())?;
        let tolerance = self.tolerance.unwrap_or(10.0 * n as f64 * f64::EPSILON);
        let rank = sigma.iter().filter(|&&s| s > tolerance * sigma[0]).count();
        let condition = if sigma[n - 1] > 0.0 { sigma[0] / sigma[n - 1] } else { f64::INFINITY };

        let y = ColRef::from_slice(y);
        let mut theta = if rank == n && is_sound {
            qr.solve_lstsq(y)
        } else if rank == n || self.deficient == Deficient::MinimumNorm {
            let projected = q.unwrap_or_else(|| qr.compute_thin_Q()).transpose() * y;
            let mut in_modes = u.transpose() * projected;
            for (i, &sigma) in sigma.iter().enumerate() {
                in_modes[i] = if i < rank { in_modes[i] / sigma } else { 0.0 };
            }
            &v * in_modes
        } else {
            let (channel, parameters) = (0, n);
            return Err(IdentError::RankDeficient { channel, rank, parameters, rows, condition });
        };
        for (theta, scale) in theta.iter_mut().zip(&scales) {
            *theta *= scale;
        }

        let inverse_gram = Mat::from_fn(n, n, |i, j| {
            let sum: f64 = (0..rank).map(|k| v[(i, k)] * v[(j, k)] / sigma[k].powi(2)).sum();
            sum * scales[i] * scales[j]
        });
        let rss = (y - x * &theta).squared_norm_l2();
        let coefficients = theta.iter().copied().collect();
        Ok(LinearFit { coefficients, inverse_gram, rss, rows, rank, condition })
    }

    /// The solution for `X = 0`, or below the smallest normal number: faer's pivoted QR divides by that.
    fn solve_silence(&self, n: usize, y: &[f64]) -> Result<LinearFit, IdentError> {
        let (channel, rank, rows, condition) = (0, 0, y.len(), f64::INFINITY);
        if self.deficient == Deficient::Refuse {
            let parameters = n;
            return Err(IdentError::RankDeficient { channel, rank, parameters, rows, condition });
        }
        let (coefficients, inverse_gram) = (vec![0.0; n], Mat::zeros(n, n));
        let rss = y.iter().map(|y| y * y).sum();
        Ok(LinearFit { coefficients, inverse_gram, rss, rows, rank, condition })
    }
}

impl LinearFit {
    /// Estimated variance of the noise, `rss / (rows − rank)`.
    #[must_use]
    pub fn noise_variance(&self) -> f64 {
        self.rss / (self.rows - self.rank) as f64
    }

    /// Covariance of the parameters for white noise of the estimated variance.
    #[must_use]
    pub fn covariance(&self) -> Mat<f64> {
        let (n, variance) = (self.coefficients.len(), self.noise_variance());
        Mat::from_fn(n, n, |i, j| variance * self.inverse_gram[(i, j)])
    }

    /// Standard errors of the parameters.
    #[must_use]
    pub fn standard_errors(&self) -> Vec<f64> {
        let (n, variance) = (self.coefficients.len(), self.noise_variance());
        (0..n).map(|i| (variance * self.inverse_gram[(i, i)]).sqrt()).collect()
    }
}

fn check(x: MatRef<'_, f64>, y: &[f64]) -> Result<(), IdentError> {
    let (rows, n) = (x.nrows(), x.ncols());
    if y.len() != rows {
        let (expected, found) = (Shape::new(rows, 1), Shape::new(y.len(), 1));
        return Err(ShapeError { role: "least-squares target", expected, found }.into());
    }
    if rows <= n || n == 0 {
        let (channel, parameters) = (0, n);
        return Err(IdentError::TooFewRows { channel, parameters, found: rows, skipped: 0 });
    }
    if columns::is_finite(x) && y.iter().all(|target| target.is_finite()) {
        return Ok(());
    }
    for (row, &target) in y.iter().enumerate() {
        for col in 0..n {
            let value = x[(row, col)];
            if !value.is_finite() {
                return Err(IdentError::NonFinite { role: "regressor matrix", row, col, value });
            }
        }
        if !target.is_finite() {
            let (role, col) = ("least-squares target", 0);
            return Err(IdentError::NonFinite { role, row, col, value: target });
        }
    }
    Ok(())
}

/// The power of two that brings `norm` nearest to 1; 1 for an empty column, and for one so short that no power would do.
fn power_of_two(norm: f64) -> f64 {
    if norm > 4.0 * f64::MIN_POSITIVE { (-norm.log2()).round().exp2() } else { 1.0 }
}
