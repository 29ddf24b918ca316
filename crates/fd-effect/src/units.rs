//! Units of ratios.

/// The unit of one quantity per another.
pub(super) fn per(unit: &str, by: &str) -> String {
    match (unit, by) {
        (unit, by) if unit == by => "1".to_owned(),
        (unit, "1" | "") => unit.to_owned(),
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
