//! The data of an order selection, compressed once for all candidates.

use std::{collections::HashSet, sync::OnceLock};

use faer::{Mat, MatRef};
use fd_model::Record;
use fd_numeric::dense::Dense;

use crate::{
    arx::{ArxModel, ArxOrders, Regression, check_records},
    error::IdentError,
    least_squares::LeastSquares,
    order::shared::{Columns, Fits, fit_all},
};

/// Anything that fits a model of given orders: least squares, or a closure around any other
/// identifier.
///
/// # Examples
///
/// Orders for refined instrumental variables:
///
/// ```
/// use fd_ident::{arx::ArxOrders, order::{FitOrders, OrderProblem}, refine::Sriv};
///
/// let identifier = |orders: ArxOrders, problem: &OrderProblem<'_>| {
///     Sriv::new(orders).fit(problem.records()).map(|refined| refined.estimate.model)
/// };
/// let _: &dyn FitOrders = &identifier;
/// ```
pub trait FitOrders {
    /// Fits a model of the given orders.
    ///
    /// # Errors
    ///
    /// Returns an error when these orders cannot be fitted to these data; the selection then
    /// goes on with the others.
    fn fit_orders(
        &self,
        orders: ArxOrders,
        problem: &OrderProblem<'_>,
    ) -> Result<ArxModel, IdentError>;
}

/// Training records and, per residual channel, the triangular factor of the widest regression.
///
/// A factor `R` of `[Φ y]` has the same least-squares solutions as the data themselves, for every
/// selection of columns, so all candidates share one pass through the records.
#[derive(Clone, Debug)]
pub struct OrderProblem<'r> {
    records: &'r [&'r Record],
    candidates: HashSet<ArxOrders>,
    widest: ArxOrders,
    channels: Vec<Compressed>,
    /// Least-squares fits of all candidates per channel, once somebody asks for one.
    fits: OnceLock<Vec<Fits>>,
}

#[derive(Clone, Debug)]
struct Compressed {
    regression: Regression,
    r: Mat<f64>,
    rows: usize,
    /// Mean square of the target.
    power: f64,
}

impl<'r> OrderProblem<'r> {
    pub(super) fn new(
        candidates: &[ArxOrders],
        records: &'r [&'r Record],
    ) -> Result<Self, IdentError> {
        let first = check_records(records)?;
        let (nu, ny) = (first.inputs().len(), first.outputs().len());
        let most = |of: &dyn Fn(&ArxOrders) -> usize| candidates.iter().map(of).max().unwrap_or(0);
        // Delay 0 with this many taps holds the inputs of every candidate.
        let nb = most(&|orders| if orders.nb == 0 { 0 } else { orders.delay + orders.nb });
        let offset = candidates.iter().any(|orders| orders.offset);
        let widest = ArxOrders { na: most(&|orders| orders.na), nb, delay: 0, offset };
        widest.checked_parameters(nu)?;
        let compress = |channel| Compressed::new(widest, nu, channel, records);
        let channels = (0..ny).map(compress).collect::<Result<_, _>>()?;
        let candidates = candidates.iter().copied().collect();
        Ok(Self { records, candidates, widest, channels, fits: OnceLock::new() })
    }

    /// The least-squares parameters of a candidate in one channel, from the factorisation that all
    /// of them share; nothing when its columns may be dependent.
    fn shared_fit(&self, orders: ArxOrders, nu: usize, channel: usize) -> Option<&[f64]> {
        let at = Columns { na: self.widest.na, nu, constant: self.widest.parameters(nu) - 1 };
        let fits = self.fits.get_or_init(|| {
            let fit = |channel: &Compressed| fit_all(channel.r.as_ref(), at, &self.candidates);
            self.channels.iter().map(fit).collect()
        });
        fits[channel].get(&orders).map(Vec::as_slice)
    }

    /// The training records.
    #[must_use]
    pub fn records(&self) -> &'r [&'r Record] {
        self.records
    }

    /// Samples at the start of each record that no candidate may use as targets.
    #[must_use]
    pub fn lag(&self) -> usize {
        self.widest.lag()
    }

    /// Rows of one residual channel.
    pub(super) fn rows(&self, channel: usize) -> usize {
        self.channels[channel].rows
    }

    /// Mean squared one-step error of a model in one residual channel, but not below what the
    /// rounding of the data alone would leave.
    pub(super) fn mean_square(&self, channel: usize, model: &ArxModel) -> f64 {
        let compressed = &self.channels[channel];
        let columns = self.columns(model.orders(), model.nu());
        let r = &compressed.r;
        let error = |i: usize| {
            let fitted =
                columns.iter().zip(model.channel(channel)).map(|(&j, theta)| r[(i, j)] * theta);
            r[(i, r.ncols() - 1)] - fitted.sum::<f64>()
        };
        let rss: f64 = (0..r.nrows()).map(|i| error(i).powi(2)).sum();
        let rounding = (10.0 * f64::EPSILON).powi(2) * compressed.power;
        (rss / compressed.rows as f64).max(rounding).max(f64::MIN_POSITIVE)
    }

    /// Columns of the widest regressor that make up that of `orders`.
    fn columns(&self, orders: ArxOrders, nu: usize) -> Vec<usize> {
        let inputs = self.widest.na + orders.delay * nu;
        let constant = self.widest.parameters(nu) - 1;
        (0..orders.na)
            .chain(inputs..inputs + orders.nb * nu)
            .chain(orders.offset.then_some(constant))
            .collect()
    }
}

impl Compressed {
    fn new(
        widest: ArxOrders,
        nu: usize,
        channel: usize,
        records: &[&Record],
    ) -> Result<Self, IdentError> {
        let mut regression = Regression::new(widest, nu, channel, 0);
        for record in records {
            regression.append(record, None);
        }
        let (phi, rows) = (regression.phi(), regression.target().len());
        let n = phi.ncols();
        if rows <= n {
            let found = rows;
            let error = IdentError::TooFewRows { channel, parameters: n, found, skipped: 0 };
            return Err(regression.locate(error));
        }
        let stacked =
            Mat::from_fn(
                rows,
                n + 1,
                |i, j| {
                    if j < n { phi[(i, j)] } else { regression.target()[i] }
                },
            );
        let power = stacked.col(n).squared_norm_l2() / rows as f64;
        let factor = stacked.factor_qr();
        let thin: MatRef<'_, f64> = factor.thin_R();
        let r = Mat::from_fn(n + 1, n + 1, |i, j| if i <= j { thin[(i, j)] } else { 0.0 });
        regression.forget_rows();
        Ok(Self { regression, r, rows, power })
    }
}

impl FitOrders for LeastSquares {
    fn fit_orders(
        &self,
        orders: ArxOrders,
        problem: &OrderProblem<'_>,
    ) -> Result<ArxModel, IdentError> {
        let first = check_records(problem.records)?;
        let (nu, ny) = (first.inputs().len(), first.outputs().len());
        orders.checked_parameters(nu)?;
        let columns = problem.columns(orders, nu);
        let mut theta = Vec::with_capacity(columns.len() * ny);
        for (channel, Compressed { regression, r, rows, .. }) in problem.channels.iter().enumerate()
        {
            if self.has_usual_tolerance()
                && let Some(shared) = problem.shared_fit(orders, nu, channel)
            {
                theta.extend_from_slice(shared);
                continue;
            }
            let phi = Mat::from_fn(r.nrows(), columns.len(), |i, j| r[(i, columns[j])]);
            let target: Vec<f64> = r.col(r.ncols() - 1).iter().copied().collect();
            let fit = self
                .solve(phi.as_ref(), &target)
                .map_err(|error| regression.locate(error).with_rows(*rows))?;
            theta.extend(fit.coefficients);
        }
        ArxModel::new(orders, nu, ny, theta, first.ts())
    }
}

impl<F> FitOrders for F
where
    F: Fn(ArxOrders, &OrderProblem<'_>) -> Result<ArxModel, IdentError>,
{
    fn fit_orders(
        &self,
        orders: ArxOrders,
        problem: &OrderProblem<'_>,
    ) -> Result<ArxModel, IdentError> {
        self(orders, problem)
    }
}
