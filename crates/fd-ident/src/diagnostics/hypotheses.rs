//! Tests of whiteness and of independence from the inputs.

use std::ops::RangeInclusive;

use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};

use crate::{
    diagnostics::correlation::{Stretch, autocorrelation, centred, count, products},
    error::IdentError,
};

/// Outcome of the Ljung-Box test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Whiteness {
    /// `Q`, chi-square distributed for white errors.
    pub statistic: f64,
    /// Degrees of freedom: lags less fitted parameters of the noise model.
    pub degrees_of_freedom: usize,
    /// Probability of at least this statistic if the errors are white.
    pub p_value: f64,
}

/// Outcome of the test of correlation between errors and past inputs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Independence {
    /// Lag of the largest correlation, in samples.
    pub lag: usize,
    /// That correlation in standard deviations, normally distributed if errors and inputs are
    /// independent.
    pub z: f64,
    /// Probability of at least this largest correlation, an upper bound.
    pub p_value: f64,
}

/// Tests whether `errors` are white over lags 1 to `lags`, after a fit of `na` past values.
///
/// # Errors
///
/// Returns an error unless `na < lags < samples`.
///
/// # Examples
///
/// ```
/// use fd_ident::diagnostics::whiteness;
///
/// let alternating: Vec<f64> = (0..100).map(|k| f64::from(1 - 2 * (k % 2))).collect();
/// assert!(whiteness(&[alternating], 10, 0)?.p_value < 1e-6);
/// # Ok::<(), fd_ident::IdentError>(())
/// ```
pub fn whiteness(errors: &[Stretch], lags: usize, na: usize) -> Result<Whiteness, IdentError> {
    let samples = count(errors);
    check_lags(lags, na, samples)?;
    let n = samples as f64;
    let r = autocorrelation(errors, lags);
    let sum: f64 = (1..=lags).map(|lag| r[lag].powi(2) / (n - lag as f64)).sum();
    let (statistic, degrees_of_freedom) = (n * (n + 2.0) * sum, lags - na);
    let chi_squared = ChiSquared::new(degrees_of_freedom as f64)
        .map_err(|_| IdentError::NoConvergence { what: "chi-square distribution" })?;
    Ok(Whiteness { statistic, degrees_of_freedom, p_value: chi_squared.sf(statistic) })
}

/// Tests whether `errors` are correlated with `input` at any of the given lags. Leave out the
/// lags in the regressor: least squares has made these correlations zero.
///
/// # Errors
///
/// Returns an error when there are fewer samples than lags.
pub fn independence(
    errors: &[Stretch],
    input: &[Stretch],
    lags: RangeInclusive<usize>,
) -> Result<Independence, IdentError> {
    let (first, last) = (*lags.start(), *lags.end());
    let samples = count(errors);
    check_lags(last, 0, samples)?;
    let input = centred(input);
    // Variance of the sums: Σ R_e(τ) R_u(τ) over positive and negative τ.
    let (power, of_input) = (products(errors, errors, last), products(&input, &input, last));
    let both_sides: f64 = (1..=last).map(|lag| 2.0 * power[lag] * of_input[lag]).sum();
    let white = power[0] * of_input[0];
    let variance = (white + both_sides).max(f64::EPSILON * white) / samples as f64;

    let correlations = products(errors, &input, last);
    let z = |lag: usize| if variance > 0.0 { correlations[lag] / variance.sqrt() } else { 0.0 };
    let (lag, z) = (first..=last)
        .map(|lag| (lag, z(lag)))
        .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
        .unwrap_or((first, 0.0));
    let single = 2.0 * Normal::standard().sf(z.abs());
    let p_value = (single * (last + 1 - first.min(last)) as f64).min(1.0);
    Ok(Independence { lag, z, p_value })
}

fn check_lags(lags: usize, na: usize, samples: usize) -> Result<(), IdentError> {
    if na < lags && lags < samples {
        return Ok(());
    }
    let expected = "above the fitted past values and below the number of samples";
    Err(IdentError::Setting { setting: "lags", expected, found: lags as f64 })
}
