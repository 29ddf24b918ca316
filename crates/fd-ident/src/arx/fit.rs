//! Difference equations fitted to records.

use std::borrow::Borrow;

use fd_model::Record;

use crate::{
    arx::{ArxEstimate, ArxModel, ArxOrders, check::check_records, regression::Regression},
    error::IdentError,
    least_squares::LeastSquares,
    refine::Prefilter,
};

/// Batch least squares for the difference equation (14), as in the paper's training stage.
///
/// The outputs of a record are the residual channels; each gets its own equation. Rows with a
/// missing sample anywhere in regressor or target are left out, and no row reaches from one
/// record into the next.
///
/// # Examples
///
/// ```
/// use fd_ident::arx::{ArxFit, ArxOrders};
/// use fd_model::{Channel, Record, SampleTime};
///
/// let (mut u, mut mu) = (vec![], vec![]);
/// for k in 0..50 {
///     u.push(f64::from(k * k % 7));
///     mu.push(0.5 * mu.last().unwrap_or(&0.0) + 2.0 * u[k as usize]);
/// }
/// let (input, residual) = (Channel::numbered("u", 1), Channel::numbered("mu", 1));
/// let record = Record::new(input, residual, u, mu, SampleTime::new(0.1)?)?;
/// let estimate = ArxFit::new(ArxOrders::new(1, 1, 0)).fit(&[record])?;
/// assert!((estimate.model.theta()[0] + 0.5).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ArxFit {
    orders: ArxOrders,
    solver: LeastSquares,
    lag: usize,
    prefilter: Option<Prefilter>,
}

impl ArxFit {
    /// Plain least squares for the given orders.
    #[must_use]
    pub fn new(orders: ArxOrders) -> Self {
        Self { orders, solver: LeastSquares::new(), lag: 0, prefilter: None }
    }

    /// Replaces the solver, for example by one that accepts deficient data.
    #[must_use]
    pub fn with_solver(self, solver: LeastSquares) -> Self {
        Self { solver, ..self }
    }

    /// Leaves out at least this many samples at the start of each record, so that fits of several
    /// orders use the same rows.
    #[must_use]
    pub fn with_lag(self, lag: usize) -> Self {
        Self { lag, ..self }
    }

    /// Filters the rows of the regression, see [`refine`](crate::refine).
    #[must_use]
    pub fn with_prefilter(self, prefilter: Prefilter) -> Self {
        Self { prefilter: Some(prefilter), ..self }
    }

    /// Fits one equation per residual channel to all records together.
    ///
    /// # Errors
    ///
    /// Returns an error when there are no records or they differ in channels or sample time, and
    /// when the complete rows are fewer than the parameters or do not excite them all.
    pub fn fit<R: Borrow<Record>>(&self, records: &[R]) -> Result<ArxEstimate, IdentError> {
        let first = check_records(records)?;
        let (nu, ny) = (first.inputs().len(), first.outputs().len());
        let n = self.orders.checked_parameters(nu)?;
        let mut theta = Vec::with_capacity(n * ny);
        let mut channels = Vec::with_capacity(ny);
        for channel in 0..ny {
            let mut regression = Regression::new(self.orders, nu, channel, self.lag);
            for record in records {
                regression.append(record.borrow(), self.prefilter.as_ref());
            }
            let fit = regression.solve(&self.solver)?;
            theta.extend_from_slice(&fit.coefficients);
            channels.push(fit);
        }
        let model = ArxModel::new(self.orders, nu, ny, theta, first.ts())?;
        Ok(ArxEstimate { model, channels })
    }
}
