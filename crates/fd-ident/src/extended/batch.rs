//! Pseudo-linear regression over records, iterated to a fixed point.

use std::borrow::Borrow;

use faer::Mat;
use fd_model::Record;

use crate::{
    arx::{ArxModel, ArxOrders, check_records, reflect, regressor, single_output},
    error::IdentError,
    least_squares::{LeastSquares, LinearFit},
};

/// Iterated extended least squares, see the [module](super).
///
/// # Examples
///
/// ```
/// use fd_ident::{arx::ArxOrders, extended::ExtendedLeastSquares};
///
/// let armax = ExtendedLeastSquares::new(ArxOrders::paper(2), 2).with_rounds(50);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExtendedLeastSquares {
    orders: ArxOrders,
    nc: usize,
    rounds: usize,
    tolerance: f64,
}

/// An ARMAX model and how it was reached.
#[derive(Clone, Debug, PartialEq)]
pub struct ExtendedEstimate {
    /// The deterministic part `B/A`.
    pub model: ArxModel,
    /// `c₁ … c_nc` of each residual channel.
    pub c: Vec<Vec<f64>>,
    /// The last regression of each channel over `[a, b, offset, c]`.
    pub channels: Vec<LinearFit>,
    /// Rounds of the slowest channel.
    pub rounds: usize,
    /// Whether every channel came to rest; if not, the round with the least errors was kept.
    pub converged: bool,
}

struct Fitted {
    fit: LinearFit,
    rounds: usize,
    converged: bool,
}

impl ExtendedLeastSquares {
    /// An estimator of at most 100 rounds, with `nc` coefficients of the noise.
    #[must_use]
    pub fn new(orders: ArxOrders, nc: usize) -> Self {
        Self { orders, nc, rounds: 100, tolerance: 1e-8 }
    }

    /// Sets the largest number of rounds.
    #[must_use]
    pub fn with_rounds(self, rounds: usize) -> Self {
        Self { rounds, ..self }
    }

    /// Fits one equation per residual channel to all records together.
    ///
    /// # Errors
    ///
    /// As [`ArxFit::fit`](crate::arx::ArxFit::fit); data without noise count as deficient.
    pub fn fit<R: Borrow<Record>>(&self, records: &[R]) -> Result<ExtendedEstimate, IdentError> {
        let first = check_records(records)?;
        let (nu, ny) = (first.inputs().len(), first.outputs().len());
        let n = self.orders.checked_parameters(nu)?;
        let (mut theta, mut c, mut channels) = (Vec::new(), Vec::new(), Vec::new());
        let (mut rounds, mut converged) = (0, true);
        for channel in 0..ny {
            let records: Vec<Record> = records
                .iter()
                .map(|record| single_output(record.borrow(), channel))
                .collect::<Result<_, _>>()?;
            let fitted = self.fit_channel(&records, n).map_err(|e| e.in_channel(channel))?;
            theta.extend_from_slice(&fitted.fit.coefficients[..n]);
            c.push(fitted.fit.coefficients[n..].to_vec());
            channels.push(fitted.fit);
            rounds = rounds.max(fitted.rounds);
            converged &= fitted.converged;
        }
        let model = ArxModel::new(self.orders, nu, ny, theta, first.ts())?;
        Ok(ExtendedEstimate { model, c, channels, rounds, converged })
    }

    fn fit_channel(&self, records: &[Record], n: usize) -> Result<Fitted, IdentError> {
        let mut errors = self.first_errors(records)?;
        let mut best: Option<(f64, LinearFit)> = None;
        let mut previous: Option<Vec<f64>> = None;
        let mut round = 0;
        while round < self.rounds {
            round += 1;
            let mut fit = self.regress(records, &errors)?;
            // Errors of an unstable C would grow.
            reflect(&mut fit.coefficients[n..])?;
            errors = self.errors(records, &fit.coefficients, n);
            let rss = squares(&errors);
            let moved = previous.as_ref().map_or(f64::INFINITY, |old| {
                let change: f64 =
                    old.iter().zip(&fit.coefficients).map(|(a, b)| (a - b).powi(2)).sum();
                let length: f64 = fit.coefficients.iter().map(|v| v * v).sum();
                (change / length).sqrt()
            });
            previous = Some(fit.coefficients.clone());
            if moved < self.tolerance {
                return Ok(Fitted { fit, rounds: round, converged: true });
            }
            if rss.is_finite() && best.as_ref().is_none_or(|(least, _)| rss < *least) {
                best = Some((rss, fit));
            }
        }
        let (_, fit) = best.ok_or(IdentError::NoConvergence { what: "extended least squares" })?;
        Ok(Fitted { fit, rounds: round, converged: false })
    }

    /// Errors of a long equation without noise model, which come near the true noise.
    fn first_errors(&self, records: &[Record]) -> Result<Vec<Vec<f64>>, IdentError> {
        let longer = self.nc.max(2) * 2;
        let long =
            ArxOrders { na: self.orders.na + longer, nb: self.orders.nb + longer, ..self.orders };
        let with = |orders| {
            let plain = Self { orders, nc: 0, ..*self };
            let silent: Vec<Vec<f64>> = records.iter().map(|r| vec![0.0; r.len()]).collect();
            let fit = plain.regress(records, &silent)?;
            let n = fit.coefficients.len();
            Ok(plain.errors(records, &fit.coefficients, n))
        };
        with(long).or_else(|_: IdentError| with(self.orders))
    }

    /// The regressor at sample `k`, without the part of the noise.
    fn plain_row(&self, record: &Record, k: usize) -> Option<Vec<f64>> {
        let row: Vec<f64> = regressor(self.orders, record, 0, k).collect();
        let complete = record.y(k)[0].is_finite() && row.iter().all(|v| v.is_finite());
        complete.then_some(row)
    }

    fn regress(&self, records: &[Record], errors: &[Vec<f64>]) -> Result<LinearFit, IdentError> {
        let (mut rows, mut target, mut skipped) = (Vec::new(), Vec::new(), 0);
        for (record, errors) in records.iter().zip(errors) {
            for k in self.orders.lag().max(self.nc)..record.len() {
                match self.plain_row(record, k) {
                    Some(mut row) => {
                        row.extend((1..=self.nc).map(|i| errors[k - i]));
                        rows.push(row);
                        target.push(record.y(k)[0]);
                    }
                    None => skipped += 1,
                }
            }
        }
        let n = self.orders.parameters(records[0].inputs().len()) + self.nc;
        let x = Mat::from_fn(rows.len(), n, |i, j| rows[i][j]);
        LeastSquares::new().solve(x.as_ref(), &target).map_err(|error| match error {
            IdentError::TooFewRows { channel, parameters, found, .. } => {
                IdentError::TooFewRows { channel, parameters, found, skipped }
            }
            other => other,
        })
    }

    /// Prediction errors, zero where they are not known.
    fn errors(&self, records: &[Record], coefficients: &[f64], n: usize) -> Vec<Vec<f64>> {
        let (theta, c) = coefficients.split_at(n);
        let one = |record: &Record| {
            let mut errors: Vec<f64> = vec![0.0; record.len()];
            for k in self.orders.lag()..record.len() {
                let Some(row) = self.plain_row(record, k) else { continue };
                let known: f64 = row.iter().zip(theta).map(|(phi, theta)| phi * theta).sum();
                let noise: f64 = c
                    .iter()
                    .enumerate()
                    .filter(|(i, _)| k > *i)
                    .map(|(i, c)| c * errors[k - 1 - i])
                    .sum();
                errors[k] = record.y(k)[0] - known - noise;
            }
            errors
        };
        records.iter().map(one).collect()
    }
}

fn squares(errors: &[Vec<f64>]) -> f64 {
    errors.iter().flatten().map(|e| e * e).sum()
}
