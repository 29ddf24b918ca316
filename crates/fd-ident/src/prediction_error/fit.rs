//! Prediction-error estimates of records, one residual channel after the other.

use std::borrow::Borrow;

use faer::Mat;
use fd_model::Record;

use super::{
    bordered::Compressed,
    gauss_newton::{Minimum, Patience, SumOfSquares, minimise},
    predictor::{NoiseStructure, Predictor, Stretch},
    problem::Problem,
    start::{left_over, noise_start},
};
use crate::{
    arx::{
        ArxEstimate, ArxFit, ArxModel, ArxOrders, Projection, Start, check_records, held_inputs,
        single_output,
    },
    error::IdentError,
    extended::ExtendedLeastSquares,
    least_squares::{Deficient, LeastSquares, LinearFit},
    refine::Sriv,
};

/// A prediction-error estimator of `μ = B/A u + C/D e`, see the [module](super).
///
/// # Examples
///
/// ```
/// use fd_ident::{arx::ArxOrders, prediction_error::PredictionError};
/// use fd_model::{Channel, Record, SampleTime};
///
/// let (mut u, mut mu) = (vec![], vec![]);
/// for k in 0..60 {
///     u.push(f64::from(k * k % 7));
///     mu.push(0.5 * mu.last().unwrap_or(&0.0) + 2.0 * u[k as usize]);
/// }
/// let (input, residual) = (Channel::numbered("u", 1), Channel::numbered("mu", 1));
/// let record = Record::new(input, residual, u, mu, SampleTime::new(0.1)?)?;
/// let fit = PredictionError::output_error(ArxOrders::new(1, 1, 0)).fit(&[record])?;
/// assert!((fit.model.theta()[0] + 0.5).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PredictionError {
    orders: ArxOrders,
    noise: NoiseStructure,
    start: Start,
    rounds: usize,
    to_rest: bool,
}

/// Fitted models with the noise that they assume.
#[derive(Clone, Debug, PartialEq)]
pub struct PredictionErrorEstimate {
    /// The deterministic part `B/A`, which is what a compensation simulates.
    pub model: ArxModel,
    /// One entry per residual channel.
    pub channels: Vec<ChannelFit>,
}

/// The fit of one residual channel.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelFit {
    /// The noise model.
    pub noise: NoiseModel,
    /// Parameters `[a, b, offset, c, d]` with covariance, noise variance, rank and condition at
    /// the end of the search; the past of the records is accounted for, but not listed.
    pub fit: LinearFit,
    /// Rounds of the search.
    pub rounds: usize,
    /// Whether it came to rest.
    pub converged: bool,
}

/// `C(q)/D(q) e` with `C = 1 + c₁ q⁻¹ + …`, `D = 1 + d₁ q⁻¹ + …`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NoiseModel {
    /// `c₁ …`.
    pub c: Vec<f64>,
    /// `d₁ …`; for ARMAX those of `A`.
    pub d: Vec<f64>,
}

impl PredictionError {
    /// An estimator that searches at most 100 rounds and estimates where each record starts.
    #[must_use]
    pub fn new(orders: ArxOrders, noise: NoiseStructure) -> Self {
        Self { orders, noise, start: Start::Estimated, rounds: 100, to_rest: false }
    }

    /// White measurement noise, `μ = B/A u + e`.
    #[must_use]
    pub fn output_error(orders: ArxOrders) -> Self {
        Self::new(orders, NoiseStructure::OutputError)
    }

    /// Coloured measurement noise, `μ = B/A u + C/D e`.
    #[must_use]
    pub fn box_jenkins(orders: ArxOrders, nc: usize, nd: usize) -> Self {
        Self::new(orders, NoiseStructure::BoxJenkins { nc, nd })
    }

    /// Moving-average equation noise, `A μ = B u + C e`.
    #[must_use]
    pub fn armax(orders: ArxOrders, nc: usize) -> Self {
        Self::new(orders, NoiseStructure::Armax { nc })
    }

    /// Takes every record to begin at rest, which saves `na` parameters per record. Without
    /// meaning for ARMAX, which begins with the measured past.
    #[must_use]
    pub fn from_rest(self) -> Self {
        Self { start: Start::Rest, ..self }
    }

    /// Sets the largest number of rounds.
    #[must_use]
    pub fn with_rounds(self, rounds: usize) -> Self {
        Self { rounds, ..self }
    }

    /// Takes a search that has not come to rest for an error, at the first residual channel where that is so.
    #[must_use]
    pub fn to_rest(self) -> Self {
        Self { to_rest: true, ..self }
    }

    /// Fits one model per residual channel to all records together.
    ///
    /// # Errors
    ///
    /// As [`ArxFit::fit`], from which the search starts, when there are not more samples than
    /// parameters, and as [`PredictionError::to_rest`] asks for.
    pub fn fit<R: Borrow<Record>>(
        &self,
        records: &[R],
    ) -> Result<PredictionErrorEstimate, IdentError> {
        let first = check_records(records)?;
        let (nu, ny) = (first.inputs().len(), first.outputs().len());
        let (mut theta, mut channels) = (Vec::new(), Vec::new());
        let n = self.orders.checked_parameters(nu)?;
        for channel in 0..ny {
            let records: Vec<Record> = records
                .iter()
                .map(|record| single_output(record.borrow(), channel))
                .collect::<Result<_, _>>()?;
            let fitted = self.fit_channel(&records).map_err(|error| error.in_channel(channel))?;
            theta.extend_from_slice(&fitted.fit.coefficients[..n]);
            channels.push(fitted);
        }
        let model = ArxModel::new(self.orders, nu, ny, theta, first.ts())?;
        Ok(PredictionErrorEstimate { model, channels })
    }

    fn fit_channel(&self, records: &[Record]) -> Result<ChannelFit, IdentError> {
        let nu = records[0].inputs().len();
        let stretches: Vec<Stretch> = records
            .iter()
            .map(|record| Stretch { u: held_inputs(record), mu: record.output(0).collect() })
            .collect();
        let predictor = Predictor { orders: self.orders, nu, noise: self.noise, start: self.start };
        let problem = Problem { predictor, stretches };
        let (rows, parameters) = (problem.rows(), problem.parameters());
        if rows <= parameters {
            let samples = problem.stretches.iter().map(|s| s.mu.len()).sum::<usize>();
            let skipped = samples - rows;
            return Err(IdentError::TooFewRows { channel: 0, parameters, found: rows, skipped });
        }
        let energy: f64 = problem
            .stretches
            .iter()
            .flat_map(|stretch| &stretch.mu)
            .filter(|mu| mu.is_finite())
            .map(|mu| mu * mu)
            .sum();
        // Rounding of n products per sample, squared and summed.
        let floor = energy * (10.0 * f64::EPSILON).powi(2);
        let patience = Patience { rounds: self.rounds, tolerance: 1e-10, floor };
        let mut best: Option<Minimum> = None;
        for start in self.starts(records, &problem)? {
            let found = minimise(&problem, start, patience)?;
            if best.as_ref().is_none_or(|best| found.cost < best.cost) {
                best = Some(found);
            }
        }
        let best = best.ok_or(IdentError::NoConvergence { what: "prediction-error search" })?;
        if !best.cost.is_finite() || (self.to_rest && !best.converged) {
            return Err(IdentError::NoConvergence { what: "prediction-error search" });
        }
        channel_fit(&problem, &best)
    }

    /// The shared parameters that searches begin with, with a past of zeros.
    fn starts(&self, records: &[Record], problem: &Problem) -> Result<Vec<Vec<f64>>, IdentError> {
        let with_noise = |theta: &[f64], c: &[f64], d: &[f64]| {
            let mut start = [theta, c, d].concat();
            start.resize(problem.parameters(), 0.0);
            start
        };
        let plain = ArxFit::new(self.orders).fit(records)?;
        if let NoiseStructure::Armax { nc } = self.noise {
            let zero = vec![0.0; nc];
            let mut starts = vec![with_noise(plain.model.theta(), &zero, &[])];
            if let Ok(extended) = ExtendedLeastSquares::new(self.orders, nc).fit(records) {
                starts.push(with_noise(extended.model.theta(), &extended.c[0], &[]));
            }
            return Ok(starts);
        }
        let refined = Sriv::new(self.orders).fit(records).ok().map(|fit| fit.estimate);
        let (nc, nd) = self.noise.own();
        [Some(plain), refined]
            .into_iter()
            .flatten()
            .map(|ArxEstimate { model, .. }| {
                let (model, _) = model.projected(Projection::Reflect, 0.999)?;
                let left = left_over(&problem.predictor, model.theta(), &problem.stretches);
                let (c, d) = noise_start(&left, nc, nd)?;
                Ok(with_noise(model.theta(), &c, &d))
            })
            .collect()
    }
}

/// Statistics at the end of a search: the covariance is `σ² (JᵀJ)⁻¹`.
fn channel_fit(problem: &Problem, best: &Minimum) -> Result<ChannelFit, IdentError> {
    let predictor = problem.predictor;
    let shared = predictor.shared();
    let eliminated = Compressed::new(problem.linearise(&best.parameters)).shared_rows();
    // A row of nothing more, as the solver wants more rows than columns.
    let x = Mat::from_fn(eliminated.nrows() + shared + 1, shared, |i, j| {
        if i < eliminated.nrows() { eliminated[(i, j)] } else { 0.0 }
    });
    let errors: Vec<f64> = (0..x.nrows())
        .map(|i| if i < eliminated.nrows() { eliminated[(i, shared)] } else { 0.0 })
        .collect();
    let solver = LeastSquares::new().when_deficient(Deficient::MinimumNorm);
    let local = solver.solve(x.as_ref(), &errors)?;
    let own = problem.parameters() - shared;
    let coefficients = best.parameters[..shared].to_vec();
    let (nc, _) = predictor.noise.own();
    let n = predictor.orders.parameters(predictor.nu);
    let c = coefficients[n..n + nc].to_vec();
    let d = match predictor.noise {
        NoiseStructure::Armax { .. } => coefficients[..predictor.orders.na].to_vec(),
        _ => coefficients[n + nc..].to_vec(),
    };
    let fit = LinearFit {
        coefficients,
        inverse_gram: local.inverse_gram,
        rss: best.cost,
        rows: problem.rows(),
        rank: local.rank + own,
        condition: local.condition,
    };
    let noise = NoiseModel { c, d };
    Ok(ChannelFit { noise, fit, rounds: best.rounds, converged: best.converged })
}
