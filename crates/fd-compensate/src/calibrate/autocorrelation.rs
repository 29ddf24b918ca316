//! How long a signal remembers itself.

use fd_numeric::{dot, fourier::Fourier};

/// Lags to sum, in autocorrelation times.
const WINDOW: f64 = 5.0;
/// Lags up to which a product is summed term by term; a signal that needs more gets all of them at once
/// from a Fourier transform, which costs about as much as that many sums.
const DIRECT_LAGS: usize = 64;

/// Integrated autocorrelation time `τ = 1 + 2 Σ ρ(t)` in samples, at least 1; `n / τ` is the number of
/// independent samples that `n` samples are worth.
///
/// The sum stops at the first lag that is at least five times the `τ` found so far (Sokal 1997), where
/// for an exponential memory less than 1 % is missing. Returns `None` when no such lag exists within
/// half of the signal: it is too short against its own memory, or not stationary. A constant signal
/// has `τ = 1`. The cost is that of a Fourier transform at most, `n log n`.
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
    let centred: Vec<f64> = signal.iter().map(|v| v - mean).collect();
    let power = product(&centred, 0);
    let scale = signal.iter().map(|v| v * v).sum::<f64>();
    // Rounding of the mean leaves a power of about (n eps)² of the squares in a constant signal.
    if power <= scale * (n as f64 * f64::EPSILON).powi(2) {
        return Some(1.0);
    }
    let mut far: Option<Vec<f64>> = None;
    let mut time = 1.0;
    for lag in 1..=n / 2 {
        let product = if lag <= DIRECT_LAGS {
            product(&centred, lag)
        } else {
            far.get_or_insert_with(|| products(&centred, n / 2))[lag]
        };
        time += 2.0 * product / power;
        if lag as f64 >= WINDOW * time {
            return Some(time.max(1.0));
        }
    }
    None
}

/// `Σ v(k) v(k + lag)`.
fn product(centred: &[f64], lag: usize) -> f64 {
    dot(centred, &centred[lag..])
}

/// The products of all lags up to `last`, by Wiener and Khinchin: the inverse transform of the power
/// spectrum of the signal with `last` zeros behind it, so that no lag wraps around.
fn products(centred: &[f64], last: usize) -> Vec<f64> {
    let padded = (centred.len() + last).next_power_of_two();
    let mut time = vec![0.0; padded];
    time[..centred.len()].copy_from_slice(centred);
    let mut fourier = Fourier::new();
    let mut spectrum = fourier.lines(&mut time);
    for line in &mut spectrum {
        *line = line.norm_sqr().into();
    }
    let transformed = fourier.signal_into(&mut spectrum, &mut time);
    // It only fails for buffers of another length or a spectrum that is not real at its ends, and this one is real
    // throughout.
    debug_assert!(transformed.is_ok(), "{transformed:?}");
    time.iter().take(last + 1).map(|v| v / padded as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transforms_and_sums_agree() {
        // A slow wave over something irregular, of odd length.
        let signal: Vec<f64> = (0..1001)
            .map(|k| (f64::from(k) * 0.01).sin() + (f64::from(k).powi(2) * 0.618).sin())
            .collect();
        let power = product(&signal, 0);
        for (lag, &found) in products(&signal, 500).iter().enumerate() {
            // Rounding of a transform: a few eps times log2(2048) of the largest product.
            let error = (found - product(&signal, lag)).abs();
            assert!(error < 50.0 * f64::EPSILON * power, "{lag}: {error}");
        }
    }
}
