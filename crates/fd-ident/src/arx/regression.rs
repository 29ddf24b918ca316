//! Difference equations as rows of a linear regression.

use faer::Mat;
use fd_model::Record;

use crate::{
    arx::ArxOrders,
    error::IdentError,
    least_squares::{LeastSquares, LinearFit},
};

/// Rows `φᵀ(k) θ = μ(k)` of one residual channel, gathered from any number of records.
///
/// No row reaches across the end of a record or touches a missing sample.
#[derive(Clone, Debug)]
pub(crate) struct Regression {
    orders: ArxOrders,
    /// Samples at the start of each record that are not used as targets.
    lag: usize,
    channel: usize,
    parameters: usize,
    /// Regressors, row by row.
    phi: Vec<f64>,
    target: Vec<f64>,
    skipped: usize,
}

impl Regression {
    /// An empty regression; `lag` may exceed that of the orders, so that models of several
    /// orders see the same rows.
    pub(crate) fn new(orders: ArxOrders, nu: usize, channel: usize, lag: usize) -> Self {
        Self {
            orders,
            lag: lag.max(orders.lag()),
            channel,
            parameters: orders.parameters(nu),
            phi: Vec::new(),
            target: Vec::new(),
            skipped: 0,
        }
    }

    /// Adds all rows of a record.
    pub(crate) fn append(&mut self, record: &Record) {
        for k in self.lag..record.len() {
            let start = self.phi.len();
            self.phi.extend(regressor(self.orders, record, self.channel, k));
            let target = record.y(k)[self.channel];
            if target.is_finite() && self.phi[start..].iter().all(|v| v.is_finite()) {
                self.target.push(target);
            } else {
                self.phi.truncate(start);
                self.skipped += 1;
            }
        }
    }

    /// Drops the rows and keeps only what errors need to be located.
    pub(crate) fn forget_rows(&mut self) {
        self.phi = Vec::new();
        self.target = Vec::new();
    }

    pub(crate) fn target(&self) -> &[f64] {
        &self.target
    }

    pub(crate) fn phi(&self) -> Mat<f64> {
        let n = self.parameters;
        Mat::from_fn(self.target.len(), n, |i, j| self.phi[i * n + j])
    }

    pub(crate) fn solve(&self, solver: &LeastSquares) -> Result<LinearFit, IdentError> {
        solver.solve(self.phi().as_ref(), &self.target).map_err(|error| self.locate(error))
    }

    /// Completes an error by what only this regression knows.
    pub(crate) fn locate(&self, error: IdentError) -> IdentError {
        match error.in_channel(self.channel) {
            IdentError::TooFewRows { channel, parameters, found, .. } => {
                IdentError::TooFewRows { channel, parameters, found, skipped: self.skipped }
            }
            other => other,
        }
    }
}

/// `φ(k)` of eq. (15), for `k` not below the lag of the orders.
pub(crate) fn regressor(
    orders: ArxOrders,
    record: &Record,
    channel: usize,
    k: usize,
) -> impl Iterator<Item = f64> + '_ {
    let past = (1..=orders.na).map(move |i| -record.y(k - i)[channel]);
    let inputs = (0..orders.nb).flat_map(move |i| record.u(k - orders.delay - i).iter().copied());
    past.chain(inputs).chain(orders.offset.then_some(1.0))
}
