//! The size of a signal.

/// The root of the mean square; 0 of nothing, NaN where one value is NaN.
///
/// ```
/// let gap = [3.0, f64::NAN, -3.0, 3.0];
/// assert_eq!(fd_numeric::rms(gap.into_iter().filter(|v| v.is_finite())), 3.0);
/// assert!(fd_numeric::rms(gap).is_nan());
/// assert_eq!(fd_numeric::rms([]), 0.0);
/// ```
#[must_use]
pub fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0_f64);
    for value in values {
        sum += value * value;
        count += 1.0;
    }
    f64::sqrt(sum / count.max(1.0))
}

/// The mean, and the standard deviation about it; zeros of nothing, NaN where one value is NaN.
///
/// ```
/// use fd_numeric::mean_and_deviation;
///
/// assert_eq!(mean_and_deviation([1.0, 5.0, 3.0, 3.0].into_iter()), [3.0, f64::sqrt(2.0)]);
/// assert_eq!(mean_and_deviation(std::iter::empty()), [0.0, 0.0]);
/// ```
#[must_use]
pub fn mean_and_deviation(values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let count = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / count;
    [mean, rms(values.map(|value| value - mean))]
}
