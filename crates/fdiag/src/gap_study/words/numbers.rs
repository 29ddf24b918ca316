//! Numbers with their uncertainty.

use fd_model::figure;

/// Characters of a number in a formula that is written as it is.
const SHORT: usize = 6;
/// Magnitudes that are written without an exponent.
const PLAIN: [i32; 2] = [-4, 5];

/// A value with its standard error, rounded to what the error leaves: `0.31 ± 0.02`.
#[must_use]
pub fn with_error(value: f64, error: f64) -> String {
    if !value.is_finite() {
        return "-".to_owned();
    }
    if !error.is_finite() || error <= 0.0 {
        return figure(value);
    }
    let magnitude = exponent(value.abs().max(error));
    if !(PLAIN[0]..=PLAIN[1]).contains(&magnitude) {
        let scale = 10.0_f64.powi(magnitude);
        return format!("({})e{magnitude}", with_error(value / scale, error / scale));
    }
    // One digit of the error, two when the first is a one or a two.
    let leading = error / 10.0_f64.powi(exponent(error));
    let decimals = (-exponent(error)).saturating_add(i32::from(leading < 2.95));
    let places = usize::try_from(decimals).unwrap_or(0);
    // An error of tens or more leaves no digit before them.
    let tens = 10.0_f64.powi((-decimals).max(0));
    let rounded = |x: f64| if decimals < 0 { (x / tens).round() * tens } else { x };
    format!("{:.places$} ± {:.places$}", rounded(value), rounded(error))
}

/// A value with its standard error and unit, which a pure number has not: `0.31 ± 0.02 N m`.
#[must_use]
pub fn with_unit(value: f64, error: f64, unit: &str) -> String {
    let value = with_error(value, error);
    match unit {
        "1" | "" => value,
        unit => format!("{value} {unit}"),
    }
}

/// Four significant figures.
#[must_use]
pub fn four(value: f64) -> String {
    let magnitude = exponent(value.abs());
    if !value.is_finite() {
        return "-".to_owned();
    }
    if !(PLAIN[0]..=PLAIN[1]).contains(&magnitude) {
        return format!("{value:.3e}");
    }
    let places = usize::try_from(3 - magnitude).unwrap_or(0);
    format!("{value:.places$}")
}

/// A formula with its numbers as people write them, of four digits.
///
/// ```
/// use fdiag::gap_study::words::formula;
///
/// assert_eq!(formula("tanh(x2/0.007381378883627106) + 1.23456789e-9*k^2"), "tanh(x2/0.007381) + 1.235e-9*k^2");
/// ```
#[must_use]
pub fn formula(expression: &str) -> String {
    let mut written = String::with_capacity(expression.len());
    let mut rest = expression;
    while let Some(first) = rest.chars().next() {
        let of_name = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
        let length = if first.is_ascii_digit() {
            number_length(rest)
        } else {
            rest.find(|c| !of_name(c)).unwrap_or(rest.len()).max(first.len_utf8())
        };
        let (token, after) = rest.split_at(length);
        match token.parse() {
            Ok(value) if SHORT < length => written.push_str(&shortened(value)),
            _ => written.push_str(token),
        }
        rest = after;
    }
    written
}

/// A number of four digits, without zeros at its end.
fn shortened(value: f64) -> String {
    let text = format!("{value:.3e}");
    let rounded = text.parse().unwrap_or(value);
    let is_plain = (PLAIN[0]..=PLAIN[1]).contains(&exponent(value.abs()));
    if is_plain { format!("{rounded}") } else { format!("{rounded:e}") }
}

/// Bytes of the number that a text begins with.
fn number_length(text: &str) -> usize {
    let digits = |text: &str| {
        text.len() - text.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.').len()
    };
    let mantissa = digits(text);
    let exponent =
        text[mantissa..].strip_prefix(['e', 'E']).map(|e| e.strip_prefix(['+', '-']).unwrap_or(e));
    match exponent.map(|e| (e, digits(e))) {
        Some((e, n)) if 0 < n => text.len() - e.len() + n,
        _ => mantissa,
    }
}

/// The exponent of the first digit.
#[expect(clippy::cast_possible_truncation, reason = "exponents of numbers are small")]
fn exponent(value: f64) -> i32 {
    if value > 0.0 { value.log10().floor() as i32 } else { 0 }
}

/// A probability: `0.97`, `> 0.99`, `< 0.01`.
#[must_use]
pub fn probability(p: f64) -> String {
    match p {
        p if !p.is_finite() => "-".to_owned(),
        p if 0.995 <= p => "> 0.99".to_owned(),
        p if p < 0.005 => "< 0.01".to_owned(),
        p => format!("{p:.2}"),
    }
}

/// A probability in a sentence: `p = 0.97`, `p > 0.99`.
#[must_use]
pub fn p(p: f64) -> String {
    match probability(p) {
        bound if bound.starts_with(['<', '>']) => format!("p {bound}"),
        value => format!("p = {value}"),
    }
}

/// A share in percent: `92 %`.
#[must_use]
pub fn percent(share: f64) -> String {
    format!("{} %", whole(share))
}

/// A share with its interval, in percent: `92 % (88..95)`.
#[must_use]
pub fn share(share: f64, [low, high]: [f64; 2]) -> String {
    format!("{} % ({}..{})", whole(share), whole(low), whole(high))
}

/// Percent, with one digit after the point close to all or nothing.
fn whole(share: f64) -> String {
    let percent = 100.0 * share;
    let is_edge = (99.0..100.0).contains(&percent) || (0.0..1.0).contains(&percent);
    let text = if is_edge { format!("{percent:.1}") } else { format!("{percent:.0}") };
    if text == "-0" { "0".to_owned() } else { text.trim_end_matches(".0").to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_say_how_many_digits_count() {
        assert_eq!(with_error(0.3124, 0.0213), "0.312 ± 0.021");
        assert_eq!(with_error(0.3124, 0.05), "0.31 ± 0.05");
        assert_eq!(with_error(1234.0, 87.0), "1230 ± 90");
        assert_eq!(with_error(3.14e-7, 0.5e-7), "(3.1 ± 0.5)e-7");
        assert_eq!(with_error(2.5, f64::NAN), "2.50");
        assert_eq!([1.5, 12345.0, 0.012, 3e9].map(four), ["1.500", "12345", "0.01200", "3.000e9"]);
        assert_eq!(with_error(-0.02, 0.3), "-0.0 ± 0.3");
    }

    #[test]
    fn probabilities_are_never_certain() {
        assert_eq!([0.9999, 0.97, 0.0].map(probability), ["> 0.99", "0.97", "< 0.01"]);
        assert_eq!([0.9999, 0.97].map(p), ["p > 0.99", "p = 0.97"]);
        assert_eq!(share(0.923, [0.881, 0.954]), "92 % (88..95)");
        assert_eq!(percent(0.9961), "99.6 %");
        assert_eq!(percent(-0.12), "-12 %");
    }
}
