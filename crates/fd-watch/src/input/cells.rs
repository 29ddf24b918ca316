//! What a cell may hold.

/// A cell of a column of numbers.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Cell {
    Number(f64),
    /// Nothing, or what logs write for nothing.
    Missing,
    /// Something else.
    Text(String),
}

/// Reads the text of a cell.
pub(super) fn read(text: &str, decimal_comma: bool) -> Cell {
    let text = text.trim();
    let is_missing = ["", "nan", "null", "na", "none"];
    if is_missing.iter().any(|missing| text.eq_ignore_ascii_case(missing)) {
        return Cell::Missing;
    }
    let parsed = if decimal_comma { text.replacen(',', ".", 1).parse() } else { text.parse() };
    match parsed {
        Ok(number) => finite(number, text),
        Err(_) => Cell::Text(text.chars().take(100).collect()),
    }
}

/// An infinity is no measurement.
pub(super) fn finite(number: f64, text: &str) -> Cell {
    if number.is_finite() { Cell::Number(number) } else { Cell::Text(text.to_owned()) }
}
