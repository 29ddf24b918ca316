//! Order statistics of samples that may hold infinities and NaN.

/// The median of the magnitude of a Gaussian variable, in standard deviations.
const GAUSSIAN_MEDIAN: f64 = 0.674_489_750_196_082;

/// The `p`-quantile by linear interpolation (Hyndman & Fan 1996, type 7), NaN left out; NaN when
/// nothing is left. Sorts in place.
///
/// ```
/// let mut values = vec![4.0, 1.0, 3.0, 2.0, f64::NAN];
/// assert_eq!(fd_numeric::quantile(&mut values, 0.5), 2.5);
/// assert_eq!(fd_numeric::quantile(&mut values, 1.0), 4.0);
/// ```
pub fn quantile(values: &mut Vec<f64>, p: f64) -> f64 {
    values.retain(|v| !v.is_nan());
    values.sort_unstable_by(f64::total_cmp);
    let Some(last) = values.len().checked_sub(1) else { return f64::NAN };
    let at = p.clamp(0.0, 1.0) * last as f64;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to last")]
    let below = at.floor() as usize;
    let (low, high) = (values[below], values[(below + 1).min(last)]);
    let share = at - at.floor();
    // No difference is taken between infinities.
    if share > 0.0 && high > low { low * (1.0 - share) + high * share } else { low }
}

/// The median, which lies half way between the two middle values of an even count; see [`quantile`].
///
/// ```
/// let mut values = vec![f64::INFINITY, 1.0, f64::INFINITY];
/// assert!(fd_numeric::median(&mut values).is_infinite());
/// assert!(fd_numeric::median(&mut Vec::new()).is_nan());
/// ```
pub fn median(values: &mut Vec<f64>) -> f64 {
    quantile(values, 0.5)
}

/// The middle value, of an even count the upper one of the two: always a value that was there. `None` of
/// nothing. Sorts in place, NaN last.
///
/// ```
/// assert_eq!(fd_numeric::upper_median(&mut [4.0, 1.0, 3.0, 2.0]), Some(3.0));
/// assert_eq!(fd_numeric::upper_median(&mut []), None);
/// ```
pub fn upper_median(values: &mut [f64]) -> Option<f64> {
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// The standard deviation of Gaussian noise with these magnitudes, from their [`upper_median`]: up to half of
/// them may be anything else. `None` of nothing. Sorts in place.
///
/// ```
/// let mut sizes = [0.1, 0.674_489_750_196_082, 1e9];
/// assert_eq!(fd_numeric::robust_deviation(&mut sizes), Some(1.0));
/// ```
pub fn robust_deviation(magnitudes: &mut [f64]) -> Option<f64> {
    upper_median(magnitudes).map(|median| median / GAUSSIAN_MEDIAN)
}
