//! Numbers as people read them.

/// Three significant figures.
#[must_use]
pub fn figure(value: f64) -> String {
    if !value.is_finite() {
        return "-".to_owned();
    }
    let magnitude = value.abs();
    if magnitude >= 100.0 {
        format!("{value:.0}")
    } else if magnitude >= 10.0 {
        format!("{value:.1}")
    } else if magnitude >= 1.0 {
        format!("{value:.2}")
    } else if magnitude >= 0.001 || magnitude == 0.0 {
        let text = format!("{value:.4}");
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        format!("{value:.1e}")
    }
}

/// A time in seconds, in the unit in which people would say it.
///
/// ```
/// use fd_model::duration;
///
/// assert_eq!([90.0, 600.0, 5520.0, 9000.0].map(duration), ["90 s", "10 min", "92 min", "2.5 h"]);
/// ```
#[must_use]
pub fn duration(seconds: f64) -> String {
    let (number, unit) = match seconds {
        s if s < 120.0 => (s, "s"),
        s if s < 7200.0 => (s / 60.0, "min"),
        s => (s / 3600.0, "h"),
    };
    let text = figure(number);
    let is_fraction = text.contains('.') && !text.contains('e');
    let text = if is_fraction { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    format!("{text} {unit}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_figures_are_enough() {
        let texts = [1234.5, 12.34, 1.234, 0.1234, 1.234e-4, 0.0, f64::NAN].map(figure);
        assert_eq!(texts, ["1234", "12.3", "1.23", "0.1234", "1.2e-4", "0", "-"]);
    }
}
