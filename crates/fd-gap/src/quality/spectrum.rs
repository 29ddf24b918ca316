//! Lines in the spectrum of a residual.

use fd_numeric::fourier::Fourier;

/// How much finer than one over the length of the signal the spectrum is computed.
const PADDING: usize = 4;

/// Frequencies of the highest peaks of the power spectra of signals, added up after each was
/// divided by its own power; in cycles per sample, highest peak first, at most `count`. Missing
/// samples and those beyond the end are zero; a mean is taken off.
///
/// ```
/// use fd_gap::quality::spectral_peaks;
///
/// let wave = |f: f64| move |k: i32| (2.0 * std::f64::consts::PI * f * f64::from(k)).sin();
/// let signal: Vec<f64> = (0..500).map(|k| wave(0.031)(k) + 0.3 * wave(0.2)(k)).collect();
/// let peaks = spectral_peaks(&[&signal], 2);
/// assert!((peaks[0] - 0.031).abs() < 5e-4);
/// ```
#[must_use]
pub fn spectral_peaks(signals: &[&[f64]], count: usize) -> Vec<f64> {
    let longest = signals.iter().map(|signal| signal.len()).max().unwrap_or(0);
    let n = (PADDING * longest).next_power_of_two().max(PADDING);
    let mut power = vec![0.0; n / 2];
    let mut fourier = Fourier::new();
    for signal in signals {
        let finite = || signal.iter().filter(|v| v.is_finite());
        let mean = finite().sum::<f64>() / finite().count().max(1) as f64;
        let total = finite().map(|v| (v - mean).powi(2)).sum::<f64>();
        if total <= 0.0 {
            continue;
        }
        let value = |v: &f64| if v.is_finite() { v - mean } else { 0.0 };
        let mut padded: Vec<f64> = signal.iter().map(value).collect();
        padded.resize(n, 0.0);
        let lines = fourier.lines(&mut padded);
        power.iter_mut().zip(&lines).for_each(|(p, line)| *p += line.norm_sqr() / total);
    }
    let is_peak = |k: &usize| power[k - 1] < power[*k] && power[k + 1] <= power[*k];
    let mut peaks: Vec<usize> = (1..n / 2 - 1).filter(is_peak).collect();
    peaks.sort_by(|a, b| power[*b].total_cmp(&power[*a]));
    peaks.truncate(count);
    peaks.into_iter().map(|k| k as f64 / n as f64).collect()
}
