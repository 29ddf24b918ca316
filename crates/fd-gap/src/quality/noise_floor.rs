//! How much of a residual is noise, whatever the model.

use fd_numeric::{rms, robust_deviation};

use super::Autoregression;

/// Errors up to so many times the noise may be noise: its size is known no better.
pub(crate) const AT_THE_NOISE: f64 = 1.2;
/// Errors of so many times the noise are explained down to it.
pub(crate) const EXPLAINED: f64 = 1.5;
/// Errors within this many times the noise may be noise of another colour; beyond it they are the work of something else, and
/// likelihoods are no use.
pub(crate) const REACHED: f64 = 2.0;

/// Standard deviation of white noise on a slow signal, `rms(Δ³ r) / √20`: a third difference
/// removes what is locally a parabola, and multiplies the variance of white noise by
/// `1 + 9 + 9 + 1`. `None` without four samples in a row.
///
/// *When not to use:* a signal that moves within four samples raises it; a sensor that filters or
/// noise that is slow lowers it.
///
/// ```
/// use fd_gap::quality::third_difference_floor;
///
/// let parabola: Vec<f64> = (0..20).map(|k| f64::from(k * k)).collect();
/// assert_eq!(third_difference_floor(&parabola), Some(0.0));
/// ```
#[must_use]
pub fn third_difference_floor(signal: &[f64]) -> Option<f64> {
    let differences = signal.windows(4).map(|w| w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]);
    let (mut sum, mut count) = (0.0, 0.0);
    for difference in differences.filter(|d| d.is_finite()) {
        sum += difference * difference;
        count += 1.0;
    }
    (0.0 < count).then(|| f64::sqrt(sum / count / 20.0))
}

/// As [`third_difference_floor`], from the median instead of the mean of squares: a few jumps, such
/// as those of a model without a dead zone, do not count.
///
/// ```
/// use fd_gap::quality::robust_third_difference_floor;
///
/// let mut step = [0.0; 40];
/// step[20..].fill(5.0);
/// assert_eq!(robust_third_difference_floor(&step), Some(0.0));
/// ```
#[must_use]
pub fn robust_third_difference_floor(signal: &[f64]) -> Option<f64> {
    let differences = signal.windows(4).map(|w| w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]);
    let mut sizes: Vec<f64> = differences.filter(|d| d.is_finite()).map(f64::abs).collect();
    robust_deviation(&mut sizes).map(|deviation| deviation / f64::sqrt(20.0))
}

/// The smaller of [`third_difference_floor`] and the standard deviation of the innovation of an
/// autoregression of order up to 12; within 0.6 and 4 times the noise that the sensor is said to
/// have, if that is known.
///
/// ```
/// use fd_gap::quality::noise_floor;
///
/// let r: Vec<f64> = (0..200).map(|k| if k % 2 == 0 { 1.0 } else { -1.0 }).collect();
/// assert_eq!(noise_floor(&r, Some(2.0)), Some(1.2));
/// ```
#[must_use]
pub fn noise_floor(residual: &[f64], stated: Option<f64>) -> Option<f64> {
    let third = third_difference_floor(residual)?;
    let innovation = rms(residual.iter().copied().filter(|v| v.is_finite()))
        * Autoregression::fit(&[residual], Autoregression::HIGHEST_ORDER).innovation();
    let floor = third.min(innovation);
    Some(stated.map_or(floor, |stated| floor.clamp(0.6 * stated, 4.0 * stated)))
}
