//! Instrumental variables over records, by two-stage least squares.

use std::borrow::Borrow;

use faer::{ColRef, Mat, MatRef};
use fd_model::Record;
use fd_numeric::dense::Dense;
use serde::{Deserialize, Serialize};

use crate::{
    arx::{
        ArxEstimate, ArxFit, ArxModel, ArxOrders, Projection, Start, check_records, regressor,
        single_output,
    },
    error::IdentError,
    least_squares::{LeastSquares, LinearFit},
};

/// Largest radius to which an unstable auxiliary model is reflected.
const LARGEST_RADIUS: f64 = 0.999;

/// What stands for past `μ` in the instruments.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Instruments {
    /// `na` inputs older than those of the equation.
    DelayedInputs {},
    /// `μ(k−lag−1) … μ(k−lag−na)`; white measurement noise needs `lag ≥ na`.
    DelayedOutputs {
        /// Samples to go further back.
        lag: usize,
    },
    /// The bias as simulated by the model of the round before; the first one is least squares.
    Simulated {
        /// Number of rounds.
        #[serde(default = "three")]
        rounds: usize,
    },
}

fn three() -> usize {
    3
}

impl Default for Instruments {
    fn default() -> Self {
        Self::Simulated { rounds: three() }
    }
}

/// An instrumental-variable estimator.
///
/// # Examples
///
/// ```
/// use fd_ident::{arx::ArxOrders, instrumental::{Instruments, InstrumentalVariables}};
/// use fd_model::{Channel, Record, SampleTime};
///
/// let (mut u, mut mu) = (vec![], vec![]);
/// for k in 0..60 {
///     u.push(f64::from(k * k % 7));
///     mu.push(0.5 * mu.last().unwrap_or(&0.0) + 2.0 * u[k as usize]);
/// }
/// let (input, residual) = (Channel::numbered("u", 1), Channel::numbered("mu", 1));
/// let record = Record::new(input, residual, u, mu, SampleTime::new(0.1)?)?;
/// let iv = InstrumentalVariables::new(ArxOrders::new(1, 1, 0), Instruments::DelayedInputs {});
/// assert!((iv.fit(&[record])?.model.theta()[0] + 0.5).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InstrumentalVariables {
    orders: ArxOrders,
    instruments: Instruments,
}

impl InstrumentalVariables {
    /// An estimator with the given instruments.
    #[must_use]
    pub fn new(orders: ArxOrders, instruments: Instruments) -> Self {
        Self { orders, instruments }
    }

    /// Fits one equation per residual channel to all records together. The covariance in the
    /// estimate is that for white equation noise.
    ///
    /// # Errors
    ///
    /// As [`ArxFit::fit`]; rank deficiency may then be that of the instruments.
    pub fn fit<R: Borrow<Record>>(&self, records: &[R]) -> Result<ArxEstimate, IdentError> {
        let first = check_records(records)?;
        let (nu, ny) = (first.inputs().len(), first.outputs().len());
        self.orders.checked_parameters(nu)?;
        let (mut theta, mut channels) = (Vec::new(), Vec::new());
        for channel in 0..ny {
            let records: Vec<Record> = records
                .iter()
                .map(|record| single_output(record.borrow(), channel))
                .collect::<Result<_, _>>()?;
            let fit = self.fit_channel(&records).map_err(|error| error.in_channel(channel))?;
            theta.extend_from_slice(&fit.coefficients);
            channels.push(fit);
        }
        let model = ArxModel::new(self.orders, nu, ny, theta, first.ts())?;
        Ok(ArxEstimate { model, channels })
    }

    fn fit_channel(&self, records: &[Record]) -> Result<LinearFit, IdentError> {
        let orders = self.orders;
        match self.instruments {
            Instruments::DelayedInputs {} => {
                let longer = ArxOrders { na: 0, nb: orders.nb + orders.na, ..orders };
                self.solve(records, longer.lag(), |record, k| {
                    regressor(longer, &records[record], 0, k).collect()
                })
            }
            Instruments::DelayedOutputs { lag } => {
                let na = orders.na;
                self.solve(records, lag + na, |record, k| {
                    let record = &records[record];
                    let past = (1..=na).map(|i| -record.y(k - lag - i)[0]);
                    past.chain(regressor(orders, record, 0, k).skip(na)).collect()
                })
            }
            Instruments::Simulated { rounds } => {
                let mut model = ArxFit::new(orders).fit(records)?.model;
                let mut fit = None;
                for _ in 0..rounds.max(1) {
                    let (stable, _) = model.projected(Projection::Reflect, LARGEST_RADIUS)?;
                    let simulated: Vec<Vec<f64>> = records
                        .iter()
                        .map(|record| stable.simulate_record(record, Start::Estimated))
                        .collect::<Result<_, _>>()?;
                    let found = self.solve(records, 0, |record, k| {
                        let past = (1..=orders.na).map(|i| -simulated[record][k - i]);
                        let rest = regressor(orders, &records[record], 0, k).skip(orders.na);
                        past.chain(rest).collect()
                    })?;
                    let theta = found.coefficients.clone();
                    model = ArxModel::new(orders, model.nu(), 1, theta, model.ts())?;
                    fit = Some(found);
                }
                fit.ok_or(IdentError::NoConvergence { what: "instrumental variables" })
            }
        }
    }

    /// Gathers complete rows with their instruments, from sample `lag` of each record on.
    fn solve(
        &self,
        records: &[Record],
        lag: usize,
        instruments: impl Fn(usize, usize) -> Vec<f64>,
    ) -> Result<LinearFit, IdentError> {
        let (mut phi, mut z, mut target) = (Vec::new(), Vec::new(), Vec::new());
        let mut skipped = 0;
        for (index, record) in records.iter().enumerate() {
            for k in lag.max(self.orders.lag())..record.len() {
                let row: Vec<f64> = regressor(self.orders, record, 0, k).collect();
                let instrument = instruments(index, k);
                let y = record.y(k)[0];
                if row.iter().chain(&instrument).chain([&y]).all(|v| v.is_finite()) {
                    phi.push(row);
                    z.push(instrument);
                    target.push(y);
                } else {
                    skipped += 1;
                }
            }
        }
        let matrix = |rows: &[Vec<f64>]| {
            Mat::from_fn(rows.len(), rows.first().map_or(0, Vec::len), |i, j| rows[i][j])
        };
        two_stage(matrix(&phi).as_ref(), matrix(&z).as_ref(), &target).map_err(|e| match e {
            IdentError::TooFewRows { channel, parameters, found, .. } => {
                IdentError::TooFewRows { channel, parameters, found, skipped }
            }
            other => other,
        })
    }
}

/// Two-stage least squares: `Φ` is replaced by its projection onto the instruments, and the sum
/// of squares is that of `Φ` itself.
///
/// # Errors
///
/// As [`LeastSquares::solve`], for the instruments and for the projection.
pub(crate) fn two_stage(
    phi: MatRef<'_, f64>,
    z: MatRef<'_, f64>,
    target: &[f64],
) -> Result<LinearFit, IdentError> {
    // Checks sizes, finiteness and rank of the instruments: QR alone would make up directions.
    LeastSquares::new().solve(z, target)?;
    let q = z.factor_qr().compute_thin_Q();
    let projected = &q * (q.transpose() * phi);
    let mut fit = LeastSquares::new().solve(projected.as_ref(), target)?;
    let (y, theta) = (ColRef::from_slice(target), ColRef::from_slice(&fit.coefficients));
    fit.rss = (y - phi * theta).squared_norm_l2();
    Ok(fit)
}
