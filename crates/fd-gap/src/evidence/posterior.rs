//! From evidence to probabilities.

/// `ln mean exp`: the evidence of a family of laws, each as likely as the other.
///
/// ```
/// use fd_gap::evidence::pool;
///
/// assert!((pool(&[3.0, 3.0]) - 3.0).abs() < 1e-12);
/// assert_eq!(pool(&[]), f64::NEG_INFINITY);
/// ```
#[must_use]
pub fn pool(laws: &[f64]) -> f64 {
    log_sum_exp(laws) - (laws.len().max(1) as f64).ln()
}

/// Logarithm of a sum of exponentials, without overflow.
fn log_sum_exp(values: &[f64]) -> f64 {
    let top = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if top.is_infinite() {
        return top;
    }
    top + values.iter().map(|v| (v - top).exp()).sum::<f64>().ln()
}

/// Probabilities of causes.
#[derive(Clone, Debug, PartialEq)]
pub struct Posterior {
    /// Of no gap.
    pub no_gap: f64,
    /// Of each cause.
    pub causes: Vec<f64>,
}

/// Probabilities of "no gap" and of causes, from their evidence relative to that of "no gap".
/// Before the data, "no gap" has probability `no_gap`, and causes are alike. Evidence is divided
/// by `temperature`, which calibration sets: above 1 when evidence is too sure of itself.
///
/// ```
/// use fd_gap::evidence::posterior;
///
/// let even = posterior(&[0.0, 0.0], 0.5, 1.0);
/// assert_eq!((even.no_gap, even.causes[0]), (0.5, 0.25));
/// ```
#[must_use]
pub fn posterior(causes: &[f64], no_gap: f64, temperature: f64) -> Posterior {
    let each = ((1.0 - no_gap) / causes.len().max(1) as f64).ln();
    let causes = causes.iter().map(|evidence| evidence / temperature + each);
    let mut all: Vec<f64> = std::iter::once(no_gap.ln()).chain(causes).collect();
    let total = log_sum_exp(&all);
    for value in &mut all {
        *value = (*value - total).exp();
    }
    Posterior { no_gap: all[0], causes: all[1..].to_vec() }
}
