//! The same stable filter for all signals of a record.

use fd_model::{Record, SampleTime};

use crate::{
    arx::{ArxModel, ArxOrders},
    error::IdentError,
    rls::positive,
};

/// A stable filter `(b₀ + b₁ z⁻¹ + …) / (1 + a₁ z⁻¹ + …)`.
///
/// # Examples
///
/// ```
/// use fd_ident::refine::Prefilter;
/// use fd_model::{Channel, Record, SampleTime};
///
/// let ts = SampleTime::new(0.1)?;
/// let (u, y) = (vec![3.0; 20], vec![1.0; 20]);
/// let record = Record::new(Channel::numbered("u", 1), Channel::numbered("y", 1), u, y, ts)?;
/// let smooth = Prefilter::low_pass(2, 1.0, ts)?.apply(&record)?;
/// assert!((smooth.u(19)[0] - 3.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Prefilter {
    /// `b₀, b₁ …` and `1, a₁, …`, of equal length.
    b: Vec<f64>,
    a: Vec<f64>,
}

impl Prefilter {
    /// A filter from `b₀, b₁, …` and `a₁, a₂, …`.
    ///
    /// # Errors
    ///
    /// Returns an error when there is no numerator, a coefficient is not finite, or a pole is on
    /// or outside the unit circle.
    pub fn new(numerator: &[f64], denominator: &[f64]) -> Result<Self, IdentError> {
        let orders = ArxOrders::new(denominator.len(), numerator.len(), 0);
        let theta = denominator.iter().chain(numerator).copied().collect();
        // The sample time does not matter for the poles per sample.
        let model = ArxModel::new(orders, 1, 1, theta, SampleTime::new(1.0)?)?;
        let largest =
            model.poles(0)?.iter().fold(0.0, |largest: f64, pole| largest.max(pole.norm()));
        if numerator.is_empty() {
            return Err(IdentError::NoParameters { orders, nu: 1 });
        }
        if largest >= 1.0 {
            let (setting, expected) = ("largest pole radius of the prefilter", "below 1");
            return Err(IdentError::Setting { setting, expected, found: largest });
        }
        let len = numerator.len().max(denominator.len() + 1);
        let mut b = numerator.to_vec();
        let mut a = vec![1.0];
        a.extend_from_slice(denominator);
        b.resize(len, 0.0);
        a.resize(len, 0.0);
        Ok(Self { b, a })
    }

    /// `order` first-order lags in series with a corner at `omega` rad/s.
    ///
    /// # Errors
    ///
    /// Returns an error unless `omega` is positive and finite.
    pub fn low_pass(order: usize, omega: f64, ts: SampleTime) -> Result<Self, IdentError> {
        positive("corner frequency in rad/s", omega)?;
        let pole = (-omega * ts.seconds()).exp();
        let (mut gain, mut a) = (1.0, vec![0.0; order + 1]);
        a[0] = 1.0;
        for _ in 0..order {
            gain *= 1.0 - pole;
            for i in (1..a.len()).rev() {
                a[i] -= pole * a[i - 1];
            }
        }
        Self::new(&[gain], &a[1..])
    }

    /// The record with inputs and outputs filtered.
    ///
    /// The filter starts as if the signals had always been as in the first sample. A sample with
    /// any channel missing becomes missing in all channels, and the filter starts again behind
    /// it, in all channels alike, so that the relation between them stays as it was.
    ///
    /// # Errors
    ///
    /// Never fails for a valid record.
    pub fn apply(&self, record: &Record) -> Result<Record, IdentError> {
        let (nu, ny) = (record.inputs().len(), record.outputs().len());
        let mut memory: Option<Vec<Vec<f64>>> = None;
        let (mut u, mut y) = (Vec::new(), Vec::new());
        for k in 0..record.len() {
            if !record.is_complete(k) {
                memory = None;
                u.resize(u.len() + nu, f64::NAN);
                y.resize(y.len() + ny, f64::NAN);
                continue;
            }
            let sample = || record.u(k).iter().chain(record.y(k)).copied();
            let states = memory.get_or_insert_with(|| sample().map(|x| self.at_rest(x)).collect());
            let mut filtered = sample().zip(states).map(|(x, state)| self.step(x, state));
            u.extend(filtered.by_ref().take(nu));
            y.extend(filtered);
        }
        let (inputs, outputs) = (record.inputs().to_vec(), record.outputs().to_vec());
        Ok(Record::new(inputs, outputs, u, y, record.ts())?.starting_at(record.time(0)))
    }

    /// One sample of the transposed direct form II.
    fn step(&self, x: f64, state: &mut [f64]) -> f64 {
        let y = self.b[0] * x + state.first().copied().unwrap_or(0.0);
        for i in 0..state.len() {
            let next = state.get(i + 1).copied().unwrap_or(0.0);
            state[i] = self.b[i + 1] * x - self.a[i + 1] * y + next;
        }
        y
    }

    /// The memory after the signal has been `x` forever.
    fn at_rest(&self, x: f64) -> Vec<f64> {
        let y = x * self.b.iter().sum::<f64>() / self.a.iter().sum::<f64>();
        let from = |i: usize| (i..self.b.len()).map(|j| self.b[j] * x - self.a[j] * y).sum();
        (1..self.b.len()).map(from).collect()
    }
}
