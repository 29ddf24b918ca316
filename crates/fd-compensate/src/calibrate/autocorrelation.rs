//! How long a signal remembers itself.

/// Integrated autocorrelation time `τ = 1 + 2 Σ ρ(t)` in samples, at least 1; `n / τ` is the number of
/// independent samples that `n` samples are worth.
///
/// The sum stops at the first lag that is at least five times the `τ` found so far (Sokal 1997), where
/// for an exponential memory less than 1 % is missing. Returns `None` when no such lag exists within
/// half of the signal: it is too short against its own memory, or not stationary. A constant signal
/// has `τ = 1`.
///
/// ```
/// use fd_compensate::calibrate::autocorrelation_time;
///
/// let trend: Vec<f64> = (0..100).map(f64::from).collect();
/// assert_eq!(autocorrelation_time(&trend), None);
/// assert_eq!(autocorrelation_time(&[1.0, 1.0, 1.0]), Some(1.0));
/// ```
#[must_use]
pub fn autocorrelation_time(signal: &[f64]) -> Option<f64> {
    let n = signal.len();
    let mean = signal.iter().sum::<f64>() / n as f64;
    let product = |lag: usize| -> f64 {
        signal.iter().zip(&signal[lag..]).map(|(a, b)| (a - mean) * (b - mean)).sum()
    };
    let power = product(0);
    let scale = signal.iter().map(|v| v * v).sum::<f64>();
    // Rounding of the mean leaves a power of about (n eps)² of the squares in a constant signal.
    if power <= scale * (n as f64 * f64::EPSILON).powi(2) {
        return Some(1.0);
    }
    let mut time = 1.0;
    for lag in 1..=n / 2 {
        time += 2.0 * product(lag) / power;
        if lag as f64 >= WINDOW * time {
            return Some(time.max(1.0));
        }
    }
    None
}

/// Lags to sum, in autocorrelation times.
const WINDOW: f64 = 5.0;
