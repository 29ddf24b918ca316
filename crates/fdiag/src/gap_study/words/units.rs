//! Parameters of effects as a person would state them.

use fd_gap::diagnose::Estimate;

/// Labels whose dimensionless strength is a relative error.
const RELATIVE: [&str; 3] = ["parameter-error", "input-gain", "sensor-scale"];

/// Value, standard error and unit of a parameter, as a person would state it: the limit instead of
/// its inverse, percent instead of a relative error.
#[must_use]
pub fn shown(label: &str, estimate: &Estimate) -> (f64, f64, String) {
    let Estimate { value, standard_error, unit, .. } = estimate;
    if estimate.is_reciprocal {
        return (1.0 / value, standard_error / (value * value), inverse(unit));
    }
    if estimate.is_strength && unit == "1" && RELATIVE.contains(&label) {
        return (100.0 * value, 100.0 * standard_error, "%".to_owned());
    }
    (*value, *standard_error, unit.clone())
}

/// The unit of the inverse.
fn inverse(unit: &str) -> String {
    let bare = |unit: &str| match unit.strip_prefix('(').and_then(|u| u.strip_suffix(')')) {
        Some(inner) if !inner.contains(['(', ')']) => inner.to_owned(),
        _ => unit.to_owned(),
    };
    let grouped = |unit: &str| {
        if unit.contains([' ', '*', '/']) { format!("({})", bare(unit)) } else { unit.to_owned() }
    };
    match top_level_slash(unit) {
        _ if matches!(unit, "1" | "") => "1".to_owned(),
        Some(("1" | "", below)) => bare(below),
        Some((above, below)) => format!("{}/{}", bare(below), grouped(&bare(above))),
        None => format!("1/{}", grouped(unit)),
    }
}

/// The parts before and after the last slash that is not within parentheses.
fn top_level_slash(unit: &str) -> Option<(&str, &str)> {
    let mut depth = 0;
    let mut slash = None;
    for (i, c) in unit.char_indices() {
        match c {
            '(' => depth += 1,
            ')' => depth -= 1,
            '/' if depth == 0 => slash = Some(i),
            _ => {}
        }
    }
    slash.map(|i| (&unit[..i], &unit[i + 1..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverses_of_units() {
        let units = ["1/V", "s/V", "1/(N m)", "1", "m", "1/(m/s)", "s/(m/s)"].map(inverse);
        assert_eq!(units, ["V", "V/s", "N m", "1", "1/m", "m/s", "m/s/s"]);
    }
}
