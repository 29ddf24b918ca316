//! How large a statistic may be while all is well.
//!
//! The formulas assume independent Gaussian samples. Neither is true of most logs, so a limit from healthy
//! logs that were not learned from ([`empirical`]) is the one to alarm by; the formulas say what an ideal
//! plant would give, and are what the literature reports.

use fd_numeric::quantile;
use statrs::distribution::{ContinuousCDF, FisherSnedecor, Normal};

use crate::error::DataError;

/// The limit of Hotelling's T² of `a` components learned from `n` samples: for a sample that was not learned
/// from, `a (n² − 1) / (n (n − a)) F(a, n − a)` (Tracy, Young and Mason 1992).
///
/// # Errors
///
/// Returns an error when `level` is not between 0 and 1, or there are not more samples than components.
///
/// ```
/// use fd_data::limits::hotelling;
///
/// // Many samples: the chi-square quantile of two degrees of freedom, −2 ln(1 − level).
/// let limit = hotelling(2, 1_000_000, 0.99)?;
/// assert!((limit + 2.0 * 0.01_f64.ln()).abs() < 1e-3);
/// assert!(hotelling(5, 5, 0.99).is_err());
/// # Ok::<(), fd_data::DataError>(())
/// ```
pub fn hotelling(a: usize, n: usize, level: f64) -> Result<f64, DataError> {
    check_level(level)?;
    if n <= a || a == 0 {
        let (what, needed) = ("the limit of T²", a.max(1) + 1);
        return Err(DataError::TooFew { what, needed, found: if a == 0 { 0 } else { n } });
    }
    let (a, n) = (a as f64, n as f64);
    let f = FisherSnedecor::new(a, n - a).map_err(|_| level_error(level))?;
    Ok(a * (n * n - 1.0) / (n * (n - a)) * f.inverse_cdf(level))
}

/// The limit of Q, the squared length of a Gaussian vector whose covariance has the eigenvalues `left`
/// (Jackson and Mudholkar 1979, eq. 3.3 to 3.5); zero when there are none.
///
/// # Errors
///
/// Returns an error when `level` is not between 0 and 1.
///
/// ```
/// use fd_data::limits::jackson_mudholkar;
///
/// // Ten equal eigenvalues: chi-square of ten degrees of freedom, 23.21 at 99 %.
/// let limit = jackson_mudholkar(&[1.0; 10], 0.99)?;
/// assert!((limit - 23.21).abs() < 0.1);
/// # Ok::<(), fd_data::DataError>(())
/// ```
pub fn jackson_mudholkar(left: &[f64], level: f64) -> Result<f64, DataError> {
    check_level(level)?;
    let theta = |power: i32| left.iter().map(|value| value.powi(power)).sum::<f64>();
    let (t1, t2, t3) = (theta(1), theta(2), theta(3));
    if !(t1 > 0.0 && t2 > 0.0) {
        return Ok(0.0);
    }
    let h = 1.0 - 2.0 * t1 * t3 / (3.0 * t2 * t2);
    let normal = Normal::standard().inverse_cdf(level);
    let inner = normal * (2.0 * t2 * h * h).sqrt() / t1 + 1.0 + t2 * h * (h - 1.0) / (t1 * t1);
    // For spectra with one eigenvalue far above the rest `h` may be near or below 0, where the power is
    // void: then Box's scaled chi-square with the same two moments (Box 1954).
    let limit = t1 * inner.powf(1.0 / h);
    if h > 1e-3 && limit.is_finite() && inner > 0.0 {
        return Ok(limit);
    }
    let (scale, freedom) = (t2 / t1, t1 * t1 / t2);
    // Wilson and Hilferty (1931): the cube root of a chi-square is nearly Gaussian.
    let spread = 2.0 / (9.0 * freedom);
    Ok(scale * freedom * (1.0 - spread + normal * spread.sqrt()).max(0.0).powi(3))
}

/// The quantile of a healthy statistic at `level`.
///
/// # Errors
///
/// Returns an error when `level` is not between 0 and 1, or fewer than one value is expected above it.
///
/// ```
/// use fd_data::limits::empirical;
///
/// let healthy: Vec<f64> = (0..=100).map(f64::from).collect();
/// assert!((empirical(&healthy, 0.95)? - 95.0).abs() < 1e-12);
/// assert!(empirical(&healthy[..10], 0.99).is_err());
/// # Ok::<(), fd_data::DataError>(())
/// ```
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at least 1, capped")]
pub fn empirical(healthy: &[f64], level: f64) -> Result<f64, DataError> {
    check_level(level)?;
    let needed = (1.0 / (1.0 - level)).ceil().min(1e15) as usize;
    if healthy.len() < needed {
        let (what, found) = ("the empirical limit", healthy.len());
        return Err(DataError::TooFew { what, needed, found });
    }
    Ok(quantile(&mut healthy.to_vec(), level))
}

fn level_error(found: f64) -> DataError {
    DataError::Setting { setting: "level", expected: "between 0 and 1".to_owned(), found }
}

pub(crate) fn check_level(level: f64) -> Result<(), DataError> {
    if level > 0.0 && level < 1.0 { Ok(()) } else { Err(level_error(level)) }
}
