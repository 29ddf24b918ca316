//! Difference equations as rows of a linear regression.

use faer::Mat;
use fd_model::Record;

use crate::{
    arx::ArxOrders,
    columns::from_rows,
    error::IdentError,
    least_squares::{LeastSquares, LinearFit},
    refine::Prefilter,
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

    /// Adds all rows of a record, through a filter if there is one.
    pub(crate) fn append(&mut self, record: &Record, filter: Option<&Prefilter>) {
        let memory_len = filter.map_or(0, Prefilter::memory_len);
        let mut memory = vec![0.0; memory_len * (self.parameters + 1)];
        for k in self.lag..record.len() {
            let start = self.phi.len();
            self.phi.extend(regressor(self.orders, record, self.channel, k));
            let mut target = record.y(k)[self.channel];
            let row = &mut self.phi[start..];
            if !target.is_finite() || row.iter().any(|v| !v.is_finite()) {
                self.phi.truncate(start);
                self.skipped += 1;
                memory.fill(0.0);
                continue;
            }
            if let Some(filter) = filter {
                for (i, value) in row.iter_mut().chain([&mut target]).enumerate() {
                    let memory = &mut memory[i * memory_len..(i + 1) * memory_len];
                    *value = filter.step(*value, memory);
                }
            }
            self.target.push(target);
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
        from_rows(&self.phi, self.target.len(), self.parameters)
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
