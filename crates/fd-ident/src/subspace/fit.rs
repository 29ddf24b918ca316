//! Subspace identification of records.

use std::borrow::Borrow;

use faer::{Mat, MatRef, prelude::SolveLstsq};
use fd_model::{Discrete, Record, StateSpace};
use fd_numeric::dense::{Dense, DenseReal};

use super::{
    StateSpaceBias,
    hankel::{future_from_past, windows},
    response::fit_response,
};
use crate::{arx::check_records, error::IdentError, rls::positive};

/// A subspace estimator of a given number of states.
///
/// # Examples
///
/// ```
/// use fd_ident::subspace::Subspace;
/// use fd_model::{Channel, Record, SampleTime};
///
/// let (mut u, mut mu) = (vec![], vec![]);
/// for k in 0..100 {
///     u.push(f64::from(k * k % 7));
///     mu.push(0.5 * mu.last().unwrap_or(&0.0) + 2.0 * u[k as usize]);
/// }
/// let (input, residual) = (Channel::numbered("u", 1), Channel::numbered("mu", 1));
/// let record = Record::new(input, residual, u, mu, SampleTime::new(0.1)?)?;
/// let estimate = Subspace::new(1).with_horizon(3).fit(&[record])?;
/// assert!((estimate.model.system().a()[(0, 0)] - 0.5).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Subspace {
    order: usize,
    horizon: usize,
    offset: bool,
    from_rest: bool,
}

/// A state-space model of all residual channels and how clear its order is.
#[derive(Clone, Debug)]
pub struct SubspaceEstimate {
    /// The model.
    pub model: StateSpaceBias,
    /// Singular values of `L₃₂`; a gap behind the order of the model says that it is enough.
    pub singular_values: Vec<f64>,
    /// Whether the shift of `Γ` was unstable and had to be bent.
    pub stabilised: bool,
    /// Mean squared error of the simulation of each residual channel.
    pub mean_squares: Vec<f64>,
}

impl Subspace {
    /// An estimator of `order` states with a horizon of `2 order + 2` samples, that estimates
    /// where each record starts.
    #[must_use]
    pub fn new(order: usize) -> Self {
        Self { order, horizon: 2 * order + 2, offset: false, from_rest: false }
    }

    /// Sets the number of samples of past and of future; more than the order.
    #[must_use]
    pub fn with_horizon(self, horizon: usize) -> Self {
        Self { horizon, ..self }
    }

    /// Adds a constant to each residual channel.
    #[must_use]
    pub fn with_offset(self) -> Self {
        Self { offset: true, ..self }
    }

    /// Takes every record to begin at rest.
    #[must_use]
    pub fn from_rest(self) -> Self {
        Self { from_rest: true, ..self }
    }

    /// Fits one model to all records together. Windows with missing samples are left out.
    ///
    /// # Errors
    ///
    /// Returns an error when records differ or there are none, when the horizon does not exceed
    /// the order, when windows are fewer than their entries, or when the data do not show that
    /// many states.
    pub fn fit<R: Borrow<Record>>(&self, records: &[R]) -> Result<SubspaceEstimate, IdentError> {
        let first = check_records(records)?;
        let (nu, ny, n, horizon) =
            (first.inputs().len(), first.outputs().len(), self.order, self.horizon);
        positive("number of states", n as f64)?;
        if horizon <= n {
            let (setting, expected) = ("horizon", "above the number of states");
            return Err(IdentError::Setting { setting, expected, found: horizon as f64 });
        }
        let windows = windows(records, horizon, self.offset);
        let (channel, parameters) = (0, 2 * horizon * (nu + ny) + usize::from(self.offset));
        if windows.nrows() <= parameters {
            let found = windows.nrows();
            let skipped = records
                .iter()
                .map(|r| r.borrow().len())
                .sum::<usize>()
                .saturating_sub(found + 2 * horizon - 1);
            return Err(IdentError::TooFewRows { channel, parameters, found, skipped });
        }
        let (basis, singular_values) = future_from_past(&windows, horizon, (nu, ny), self.offset)?;
        let largest = singular_values.first().copied().unwrap_or(0.0);
        let tolerance = 10.0 * parameters as f64 * f64::EPSILON;
        let rank = singular_values.iter().filter(|&&s| s > tolerance * largest).count();
        if rank < n {
            let (rows, condition) = (windows.nrows(), f64::INFINITY);
            let parameters = n;
            return Err(IdentError::RankDeficient { channel, rank, parameters, rows, condition });
        }
        let gamma =
            Mat::from_fn(basis.nrows(), n, |i, j| basis[(i, j)] * singular_values[j].sqrt());
        let c = gamma.subrows(0, ny).to_owned();
        let (a, stabilised) = shift(gamma.as_ref(), ny)?;
        let response = fit_response(a.as_ref(), c.as_ref(), records, self.offset, self.from_rest)?;
        let system = StateSpace::new(a, response.b, c, response.d, Discrete { ts: first.ts() })?;
        let model = StateSpaceBias::new(system, response.offset, &response.error)?;
        Ok(SubspaceEstimate { model, singular_values, stabilised, mean_squares: response.error })
    }
}

/// `A` from `Γ` without its last block to `Γ` without its first.
fn shift(gamma: MatRef<'_, f64>, ny: usize) -> Result<(Mat<f64>, bool), IdentError> {
    let rows = gamma.nrows() - ny;
    let next = gamma.subrows(ny, rows);
    let a = gamma.subrows(0, rows).factor_qr().solve_lstsq(next);
    if spectral_radius(a.as_ref())? < 1.0 {
        return Ok((a, false));
    }
    let padded =
        Mat::from_fn(
            gamma.nrows(),
            gamma.ncols(),
            |i, j| {
                if i < rows { next[(i, j)] } else { 0.0 }
            },
        );
    Ok((gamma.factor_qr().solve_lstsq(padded), true))
}

fn spectral_radius(a: MatRef<'_, f64>) -> Result<f64, IdentError> {
    let eigenvalues =
        a.modes().map_err(|_| IdentError::NoConvergence { what: "eigenvalues of the shift" })?;
    Ok(eigenvalues.iter().map(|e| e.norm()).fold(0.0, f64::max))
}
