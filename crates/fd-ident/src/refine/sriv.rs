//! Simplified refined instrumental variables.

use std::borrow::Borrow;

use fd_model::Record;

use crate::{
    arx::{
        ArxEstimate, ArxFit, ArxModel, ArxOrders, Projection, Regression, Start, check_records,
        single_output,
    },
    error::IdentError,
    instrumental::two_stage,
    least_squares::LinearFit,
    refine::Prefilter,
};

/// Largest radius to which an unstable iterate is reflected.
const LARGEST_RADIUS: f64 = 0.999;

/// Refined instrumental variables for an output-error model `μ = B/A u + white noise`.
///
/// Starting from plain least squares, each round simulates `μ̂` with the present model, filters
/// input, bias and `μ̂` by `1/A`, and solves the regression with the filtered `μ̂` in place of the
/// noisy bias as instruments, by two-stage least squares. Source: Young & Jakeman (1979),
/// *Refined instrumental variable methods of recursive time-series analysis*, part I, simplified
/// for white noise; consistent for coloured noise too, then without least variance.
///
/// # When not to use it
///
/// When the bias is of higher order than the model rather than noisy: there is no reason why the
/// result should then simulate better than that of least squares, so compare both held out.
///
/// # Examples
///
/// ```
/// use fd_ident::{arx::ArxOrders, refine::Sriv};
/// use fd_model::{Channel, Record, SampleTime};
///
/// let (mut u, mut mu) = (vec![], vec![]);
/// for k in 0..60 {
///     u.push(f64::from(k * k % 7));
///     mu.push(0.5 * mu.last().unwrap_or(&0.0) + 2.0 * u[k as usize]);
/// }
/// let (input, residual) = (Channel::numbered("u", 1), Channel::numbered("mu", 1));
/// let record = Record::new(input, residual, u, mu, SampleTime::new(0.1)?)?;
/// let refined = Sriv::new(ArxOrders::new(1, 1, 0)).fit(&[record])?;
/// assert!(refined.converged);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sriv {
    orders: ArxOrders,
    rounds: usize,
    tolerance: f64,
}

/// A refined model and how it was reached.
#[derive(Clone, Debug, PartialEq)]
pub struct SrivEstimate {
    /// The model with its statistics; `rss` is that of the filtered equation.
    pub estimate: ArxEstimate,
    /// Rounds of the slowest residual channel.
    pub rounds: usize,
    /// Whether every channel came to rest before the rounds ran out.
    pub converged: bool,
}

impl Sriv {
    /// A refinement of at most 30 rounds, which ends when the frequency response changes by less
    /// than 1e-6 of its largest value.
    #[must_use]
    pub fn new(orders: ArxOrders) -> Self {
        Self { orders, rounds: 30, tolerance: 1e-6 }
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
    /// As [`ArxFit::fit`], for the least-squares start and for every round.
    pub fn fit<R: Borrow<Record>>(&self, records: &[R]) -> Result<SrivEstimate, IdentError> {
        let first = check_records(records)?;
        let (nu, ny) = (first.inputs().len(), first.outputs().len());
        let (mut theta, mut channels) = (Vec::new(), Vec::new());
        let (mut rounds, mut converged) = (0, true);
        for channel in 0..ny {
            let records: Vec<Record> = records
                .iter()
                .map(|record| single_output(record.borrow(), channel))
                .collect::<Result<_, _>>()?;
            let refined = self.refine(&records).map_err(|error| error.in_channel(channel))?;
            theta.extend_from_slice(&refined.fit.coefficients);
            channels.push(refined.fit);
            rounds = rounds.max(refined.rounds);
            converged &= refined.converged;
        }
        let model = ArxModel::new(self.orders, nu, ny, theta, first.ts())?;
        Ok(SrivEstimate { estimate: ArxEstimate { model, channels }, rounds, converged })
    }

    fn refine(&self, records: &[Record]) -> Result<Refined, IdentError> {
        let start = ArxFit::new(self.orders).fit(records)?;
        let mut model = start.model;
        let mut refined = Refined { fit: start.channels[0].clone(), rounds: 0, converged: false };
        while refined.rounds < self.rounds && !refined.converged {
            let (stable, _) = model.projected(Projection::Reflect, LARGEST_RADIUS)?;
            refined.fit = self.round(&stable, records)?;
            refined.rounds += 1;
            let theta = refined.fit.coefficients.clone();
            let next = ArxModel::new(self.orders, model.nu(), 1, theta, model.ts())?;
            refined.converged = model.response_distance(&next) < self.tolerance;
            model = next;
        }
        Ok(refined)
    }

    fn round(&self, model: &ArxModel, records: &[Record]) -> Result<LinearFit, IdentError> {
        let filter = Prefilter::new(&[1.0], model.a(0))?;
        let mut data = Regression::new(self.orders, model.nu(), 0, 0);
        let mut instruments = data.clone();
        for record in records {
            data.append(record, Some(&filter));
            instruments.append(&simulated(model, record)?, Some(&filter));
        }
        // Both regressions skip the same rows, since both have the same samples missing.
        two_stage(data.phi().as_ref(), instruments.phi().as_ref(), data.target())
            .map_err(|error| data.locate(error))
    }
}

/// A refined equation of one residual channel.
struct Refined {
    fit: LinearFit,
    rounds: usize,
    converged: bool,
}

/// The record with its bias simulated, and missing where it was missing.
fn simulated(model: &ArxModel, record: &Record) -> Result<Record, IdentError> {
    let simulated = model.simulate_record(record, Start::Estimated)?;
    let mut instrument = record.clone();
    for (k, &mu_hat) in simulated.iter().enumerate() {
        let mu = &mut instrument.y_mut(k)[0];
        if mu.is_finite() {
            *mu = mu_hat;
        }
    }
    Ok(instrument)
}
