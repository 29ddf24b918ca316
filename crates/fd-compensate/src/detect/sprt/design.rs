//! Boundaries of the test and exact run lengths.

use faer::{Mat, linalg::solvers::Solve};
use fd_numeric::dense::Dense;
use serde::{Deserialize, Serialize};
use statrs::distribution::{Continuous, ContinuousCDF, Normal};

use crate::{
    count::whole,
    detect::{
        error::{DetectorError, finite, positive},
        quadrature::gauss_legendre,
    },
};

/// Widest range of the test in steps' standard deviations that the quadrature is dense enough for.
const WIDEST: f64 = 60.0;

/// Probabilities that a test ends in the wrong way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ErrorProbabilities {
    /// `α`: alarm, though healthy.
    pub false_alarm: f64,
    /// `β`: healthy, though faulty.
    pub missed: f64,
}

impl ErrorProbabilities {
    /// Wald's boundaries `ln A`, `ln B`.
    ///
    /// ```
    /// use fd_compensate::detect::sprt::ErrorProbabilities;
    ///
    /// let errors = ErrorProbabilities { false_alarm: 0.01, missed: 0.05 };
    /// let (lower, upper) = errors.boundaries()?;
    /// assert!((lower + 2.98568).abs() < 5e-6 && (upper - 4.55388).abs() < 5e-6);
    /// # Ok::<(), fd_compensate::detect::DetectorError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when a probability is not positive or their sum is not below 1.
    pub fn boundaries(self) -> Result<(f64, f64), DetectorError> {
        positive("false-alarm probability", self.false_alarm)?;
        positive("probability of a miss", self.missed)?;
        let found = self.false_alarm + self.missed;
        if found >= 1.0 {
            let (parameter, expected) = ("sum of the error probabilities", "below 1");
            return Err(DetectorError::Parameter { parameter, expected, found });
        }
        let lower = (self.missed / (1.0 - self.false_alarm)).ln();
        Ok((lower, ((1.0 - self.missed) / self.false_alarm).ln()))
    }
}

/// What a one-sided test does on independent Gaussian samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Operating {
    /// Probability that a test ends in an alarm.
    pub alarm_probability: f64,
    /// Average samples of one test.
    pub average_samples: f64,
    /// Average samples until the restarted test alarms.
    pub average_run_length: f64,
}

/// What the one-sided test for a mean of `delta` standard deviations with boundaries `lower < 0 < upper`
/// does on independent `N(shift, 1)` samples.
///
/// ```
/// use fd_compensate::detect::sprt::{ErrorProbabilities, operating_characteristic};
///
/// let (lower, upper) = ErrorProbabilities { false_alarm: 0.01, missed: 0.05 }.boundaries()?;
/// let healthy = operating_characteristic((lower, upper), 1.0, 0.0)?;
/// // The boundaries are overshot, so that less goes wrong than was asked for.
/// assert!(healthy.alarm_probability < 0.01);
/// # Ok::<(), fd_compensate::detect::DetectorError>(())
/// ```
///
/// # Errors
///
/// Returns an error when the boundaries do not enclose zero, are too far apart for the quadrature (60
/// `delta`), `delta` is not positive or the shift is not finite.
pub fn operating_characteristic(
    boundaries: (f64, f64),
    delta: f64,
    shift: f64,
) -> Result<Operating, DetectorError> {
    positive("shift to be found", delta)?;
    finite("shift", shift)?;
    positive("upper boundary", boundaries.1)?;
    positive("minus the lower boundary", -boundaries.0)?;
    // In steps' standard deviations: S / δ moves by z − δ/2.
    let (lower, upper) = (boundaries.0 / delta, boundaries.1 / delta);
    if upper - lower > WIDEST {
        let (parameter, expected) = ("distance of the boundaries over delta", "at most 60");
        return Err(DetectorError::Parameter { parameter, expected, found: upper - lower });
    }
    let drift = shift - 0.5 * delta;
    let nodes: Vec<(f64, f64)> = gauss_legendre(24 + whole(8.0 * (upper - lower)), upper - lower)
        .into_iter()
        .map(|(x, weight)| (lower + x, weight))
        .collect();
    // Unknowns: at the start 0, then at the nodes.
    let size = nodes.len() + 1;
    let start = |i: usize| if i == 0 { 0.0 } else { nodes[i - 1].0 };
    let normal = Normal::standard();
    let system = Mat::from_fn(size, size, |i, j| {
        let transition = if j == 0 {
            0.0
        } else {
            let (x, weight) = nodes[j - 1];
            weight * normal.pdf(x - start(i) - drift)
        };
        f64::from(u8::from(i == j)) - transition
    });
    let right =
        Mat::from_fn(
            size,
            2,
            |i, column| {
                if column == 0 { 1.0 } else { normal.cdf(start(i) + drift - upper) }
            },
        );
    let solution = system.lu().solve(right);
    let (average_samples, alarm_probability) = (solution[(0, 0)], solution[(0, 1)]);
    Ok(Operating {
        alarm_probability,
        average_samples,
        average_run_length: average_samples / alarm_probability,
    })
}
