//! The whitening matrix and the threshold of the chi-square detector.

use faer::Mat;
use fd_numeric::dense::Dense;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::{detect::error::DetectorError, rows::SampleRows};

/// Threshold of the sum over `window` samples of `channels` white Gaussian channels, for the rate
/// `per_sample` of false alarms.
///
/// ```
/// use fd_compensate::detect::chi_square::threshold;
///
/// assert!((threshold(2, 1, 1e-3)? - 13.81551).abs() < 1e-5);
/// # Ok::<(), fd_compensate::detect::DetectorError>(())
/// ```
///
/// # Errors
///
/// Returns an error when there is no channel or no window, or the rate is not between 1e-12 and 1.
pub fn threshold(channels: usize, window: usize, per_sample: f64) -> Result<f64, DetectorError> {
    if !(1e-12..1.0).contains(&per_sample) {
        let (parameter, expected) = ("false-alarm rate", "between 1e-12 and 1");
        return Err(DetectorError::Parameter { parameter, expected, found: per_sample });
    }
    let found = (channels * window) as f64;
    let distribution = ChiSquared::new(found).map_err(|_| DetectorError::Parameter {
        parameter: "channels times window",
        expected: "at least 1",
        found,
    })?;
    Ok(distribution.inverse_cdf(1.0 - per_sample))
}

/// Mean and covariance of fault-free residuals.
pub(crate) fn moments(healthy: SampleRows<'_>) -> (Vec<f64>, Mat<f64>) {
    let n = healthy.len() as f64;
    let mean = healthy.per_channel(|v| v.sum::<f64>() / n);
    let covariance = Mat::from_fn(mean.len(), mean.len(), |i, j| {
        let products = healthy.iter().map(|r| (r[i] - mean[i]) * (r[j] - mean[j]));
        products.sum::<f64>() / (n - 1.0).max(1.0)
    });
    (mean, covariance)
}

/// `W` with `Wᵀ W = Σ⁻¹`: the inverse Cholesky factor of the correlation, times the inverse standard
/// deviations, so that the units of the channels do not matter to the test for singularity.
pub(crate) fn whitening(covariance: &Mat<f64>, samples: usize) -> Result<Mat<f64>, DetectorError> {
    let n = covariance.nrows();
    let sigma: Vec<f64> = (0..n).map(|i| covariance[(i, i)].sqrt()).collect();
    if let Some(channel) = sigma.iter().position(|&s| s.is_nan() || s <= 0.0) {
        return Err(DetectorError::ConstantChannel { channel, samples });
    }
    let correlation = Mat::from_fn(n, n, |i, j| covariance[(i, j)] / (sigma[i] * sigma[j]));
    let factor = correlation.cholesky().map_err(|error| {
        let faer::linalg::cholesky::llt::factor::LltError::NonPositivePivot { index } = error;
        DetectorError::SingularCovariance { channel: index }
    })?;
    // A pivot is the share of a channel's variance that the channels before it leave; rounding of
    // the Cholesky factor is about n eps, of the covariance itself sqrt(samples) eps.
    let rounding = 1e3 * n as f64 * f64::EPSILON;
    if let Some(channel) = (0..n).find(|&i| factor.L()[(i, i)].powi(2) < rounding) {
        return Err(DetectorError::SingularCovariance { channel });
    }
    let mut inverse = Mat::identity(n, n);
    factor.L().solve_lower_triangular_in_place(inverse.as_mut());
    Ok(Mat::from_fn(n, n, |i, j| inverse[(i, j)] / sigma[j]))
}
