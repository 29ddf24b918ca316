//! Numbers of a report in as many figures as they are worth, which keeps its file small.

/// Five significant figures: more than any number of a comparison is known to.
pub(super) fn rounded(value: f64) -> f64 {
    // Through text, so that the shortest form of the result is the short one.
    if value.is_finite() { format!("{value:.4e}").parse().unwrap_or(value) } else { value }
}

#[cfg(test)]
mod tests {
    use super::rounded;

    #[test]
    fn five_figures() {
        assert_eq!(
            [0.0, 1.0 / 3.0, 12345.6].map(|v| rounded(v).to_string()),
            ["0", "0.33333", "12346"]
        );
        assert!(rounded(f64::NAN).is_nan());
    }
}
