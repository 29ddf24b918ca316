//! The same stable filter for input and bias.

use fd_model::SampleTime;

use crate::{arx::roots, error::IdentError, rls::positive};

/// A stable filter `(b₀ + b₁ z⁻¹ + …) / (1 + a₁ z⁻¹ + …)`.
///
/// It is applied to the rows of the regression, target and regressor alike, which is the same as
/// filtering the signals, but without a transient: every filtered row is a sum of valid rows. At
/// the start of a record and behind missing samples the filter starts from rest.
///
/// # Examples
///
/// ```
/// use fd_ident::{arx::{ArxFit, ArxOrders}, refine::Prefilter};
/// use fd_model::SampleTime;
///
/// let smooth = Prefilter::low_pass(2, 1.0, SampleTime::new(0.1)?)?;
/// let fit = ArxFit::new(ArxOrders::paper(2)).with_prefilter(smooth);
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
        positive("number of numerator coefficients", numerator.len() as f64)?;
        let coefficients = numerator.iter().chain(denominator);
        if let Some((row, &value)) = coefficients.enumerate().find(|(_, v)| !v.is_finite()) {
            return Err(IdentError::NonFinite { role: "prefilter", row, col: 0, value });
        }
        let largest = roots(denominator)?.iter().fold(0.0, |r: f64, pole| r.max(pole.norm()));
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

    /// Numbers that the filter remembers per signal.
    pub(crate) fn memory_len(&self) -> usize {
        self.a.len() - 1
    }

    /// One sample of the transposed direct form II; a memory of zeros is a filter at rest.
    pub(crate) fn step(&self, x: f64, memory: &mut [f64]) -> f64 {
        let y = self.b[0] * x + memory.first().copied().unwrap_or(0.0);
        for i in 0..memory.len() {
            let next = memory.get(i + 1).copied().unwrap_or(0.0);
            memory[i] = self.b[i + 1] * x - self.a[i + 1] * y + next;
        }
        y
    }
}
