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

/// Probabilities of answers that exclude each other, from their evidence (its logarithm, up to a
/// constant that all share) and their prior probabilities (up to a common factor). Evidence is
/// divided by `temperature`, which calibration sets: above 1 when evidence is too sure of itself.
///
/// ```
/// use fd_gap::evidence::probabilities;
///
/// let even = probabilities(&[(0.0, 0.5), (0.0, 0.25), (0.0, 0.25)], 1.0);
/// assert_eq!(even, [0.5, 0.25, 0.25]);
/// ```
#[must_use]
pub fn probabilities(answers: &[(f64, f64)], temperature: f64) -> Vec<f64> {
    let logs: Vec<f64> =
        answers.iter().map(|(evidence, prior)| evidence / temperature + prior.ln()).collect();
    let total = log_sum_exp(&logs);
    logs.into_iter().map(|log| (log - total).exp()).collect()
}
