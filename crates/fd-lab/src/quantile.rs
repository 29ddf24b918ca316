//! Order statistics of samples that may hold infinities and NaN.

/// The `p`-quantile by linear interpolation (Hyndman & Fan 1996, type 7), NaN left out; NaN when
/// nothing is left. Sorts in place.
pub(crate) fn quantile(values: &mut Vec<f64>, p: f64) -> f64 {
    values.retain(|v| !v.is_nan());
    values.sort_by(f64::total_cmp);
    let Some(last) = values.len().checked_sub(1) else { return f64::NAN };
    let at = p.clamp(0.0, 1.0) * last as f64;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to last")]
    let below = at.floor() as usize;
    let (low, high) = (values[below], values[(below + 1).min(last)]);
    let share = at - at.floor();
    // No difference is taken between infinities.
    if share > 0.0 && high > low { low * (1.0 - share) + high * share } else { low }
}

/// The median; see [`quantile`].
pub(crate) fn median(values: &mut Vec<f64>) -> f64 {
    quantile(values, 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_interpolate_and_stand_infinities() {
        let mut values = vec![4.0, 1.0, 3.0, 2.0, f64::NAN];
        assert!((quantile(&mut values, 0.5) - 2.5).abs() < 1e-15);
        assert!((quantile(&mut values, 1.0) - 4.0).abs() < 1e-15);
        let mut values = vec![f64::INFINITY, 1.0, f64::INFINITY];
        assert!(median(&mut values).is_infinite());
        assert!(median(&mut Vec::new()).is_nan());
    }
}
