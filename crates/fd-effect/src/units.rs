//! Units of ratios.

/// The unit of one quantity per another.
pub(super) fn per(unit: &str, by: &str) -> String {
    match (unit, by) {
        (unit, by) if unit == by => "1".to_owned(),
        (unit, "1" | "") => unit.to_owned(),
        ("1" | "", by) if by.starts_with("1/") => bare(&by["1/".len()..]).to_owned(),
        ("", by) => format!("1/{}", grouped(by)),
        (unit, by) => format!(
            "{}/{}",
            if unit.contains('/') { grouped(unit) } else { unit.to_owned() },
            grouped(by)
        ),
    }
}

fn grouped(unit: &str) -> String {
    if unit.contains([' ', '/', '*']) { format!("({unit})") } else { unit.to_owned() }
}

/// A unit without the parentheses around all of it.
fn bare(unit: &str) -> &str {
    let inner = unit.strip_prefix('(').and_then(|unit| unit.strip_suffix(')'));
    inner.filter(|unit| !unit.contains(['(', ')'])).unwrap_or(unit)
}

#[cfg(test)]
mod tests {
    use super::per;

    #[test]
    fn ratios() {
        let ratios = [("1", "1/s"), ("1", "1/(N m)"), ("N", "m/s"), ("1", "V"), ("K", "K")];
        assert_eq!(ratios.map(|(a, b)| per(a, b)), ["s", "N m", "N/(m/s)", "1/V", "1"]);
    }
}
