//! Which test, and its threshold in closed form.

use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, FisherSnedecor, StudentsT};

use crate::detect::error::DetectorError;

/// What of two samples is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SampleTest {
    /// Student's test with a common variance.
    Mean,
    /// Fisher's test.
    Variance,
    /// The test of Kolmogorov and Smirnov.
    Distribution,
}

/// Least samples in a window or a reference.
pub(super) const LEAST_SAMPLES: usize = 2;

/// Threshold of one test, two-sided, with `window` and `reference` independent samples, for the rate
/// `per_sample` of false alarms.
///
/// ```
/// use fd_compensate::detect::two_sample::{SampleTest, threshold};
///
/// // With a large reference, Student's quantile: 2.262 for 9 degrees would need the reference's too.
/// let t = threshold(SampleTest::Mean, 10, 1_000_000, 0.05)?;
/// assert!((t - 1.960).abs() < 1e-3);
/// # Ok::<(), fd_compensate::detect::DetectorError>(())
/// ```
///
/// # Errors
///
/// Returns an error when a sample has fewer than two values, or the rate is not between 1e-12 and 1.
pub fn threshold(
    test: SampleTest,
    window: usize,
    reference: usize,
    per_sample: f64,
) -> Result<f64, DetectorError> {
    if !(1e-12..1.0).contains(&per_sample) {
        let (parameter, expected) = ("false-alarm rate", "between 1e-12 and 1");
        return Err(DetectorError::Parameter { parameter, expected, found: per_sample });
    }
    check(window, reference)?;
    let upper = 1.0 - 0.5 * per_sample;
    let degrees = |n: usize| (n - 1) as f64;
    let malformed = |found: f64| DetectorError::Parameter {
        parameter: "degrees of freedom",
        expected: "at least 1",
        found,
    };
    match test {
        SampleTest::Mean => {
            let freedom = degrees(window) + degrees(reference);
            let student = StudentsT::new(0.0, 1.0, freedom).map_err(|_| malformed(freedom))?;
            Ok(student.inverse_cdf(upper))
        }
        SampleTest::Variance => {
            let fisher = FisherSnedecor::new(degrees(window), degrees(reference))
                .map_err(|_| malformed(degrees(window)))?;
            let (low, high) = (fisher.inverse_cdf(1.0 - upper), fisher.inverse_cdf(upper));
            Ok(high.ln().max(-low.ln()))
        }
        SampleTest::Distribution => Ok(kolmogorov_constant(per_sample)),
    }
}

/// `c(α) = √(−ln(α/2)/2)`: the first term of Kolmogorov's distribution, which is exact to five digits for
/// `α ≤ 0.05`.
///
/// ```
/// use fd_compensate::detect::two_sample::kolmogorov_constant;
///
/// assert!((kolmogorov_constant(0.05) - 1.35810).abs() < 5e-6);
/// ```
#[must_use]
pub fn kolmogorov_constant(alpha: f64) -> f64 {
    (-0.5 * (0.5 * alpha).ln()).sqrt()
}

/// Refuses samples that are too small to have a spread.
pub(super) fn check(window: usize, reference: usize) -> Result<(), DetectorError> {
    for (parameter, found) in [("window", window), ("fault-free reference", reference)] {
        if found < LEAST_SAMPLES {
            let expected = "at least 2 samples";
            return Err(DetectorError::Parameter { parameter, expected, found: found as f64 });
        }
    }
    Ok(())
}
