//! The header of a log: names and units of columns.

use fd_model::nearest;

use crate::error::LogError;

/// A column as its header names it.
#[derive(Clone, Debug, PartialEq)]
pub struct HeaderColumn {
    /// The whole text.
    pub text: String,
    /// The text without the unit.
    pub name: String,
    /// Unit in brackets after the name.
    pub unit: Option<String>,
}

impl HeaderColumn {
    /// Splits `T_7 [K]` and `T_7 (K)` into name and unit. A whole number in square brackets right behind a name is
    /// an index, and part of the name: `gyro[0]`. As a unit, 1 stands apart: `duty [1]`.
    ///
    /// ```
    /// let column = fd_log::HeaderColumn::parse("T_7 [K]");
    /// assert_eq!((column.name.as_str(), column.unit.as_deref()), ("T_7", Some("K")));
    /// ```
    #[must_use]
    pub fn parse(text: &str) -> Self {
        let text = text.trim();
        let split = [('[', ']'), ('(', ')')].into_iter().find_map(|(open, close)| {
            let (name, unit) = text.strip_suffix(close)?.rsplit_once(open)?;
            let is_index =
                open == '[' && !unit.is_empty() && unit.bytes().all(|c| c.is_ascii_digit());
            if is_index && !name.ends_with(char::is_whitespace) {
                return None;
            }
            let name = name.trim();
            (!name.is_empty()).then(|| (name.to_owned(), unit.trim().to_owned()))
        });
        let (name, unit) = split.map_or((text.to_owned(), None), |(n, u)| (n, Some(u)));
        Self { text: text.to_owned(), name, unit }
    }
}

/// Index of the column with this text or, if there is none, this name.
pub(super) fn find(file: &str, header: &[HeaderColumn], wanted: &str) -> Result<usize, LogError> {
    let with = |same: &dyn Fn(&HeaderColumn) -> bool| -> Vec<usize> {
        (0..header.len()).filter(|&i| same(&header[i])).collect()
    };
    let mut matches = with(&|column| column.text == wanted.trim());
    if matches.is_empty() {
        matches = with(&|column| column.name == wanted.trim());
    }
    match matches[..] {
        [index] => Ok(index),
        [] => Err(LogError::MissingColumn {
            file: file.to_owned(),
            column: wanted.to_owned(),
            nearest: nearest(wanted, header.iter().map(|column| column.name.as_str()))
                .into_iter()
                .next(),
            known: texts(header),
        }),
        _ => Err(LogError::AmbiguousColumn {
            file: file.to_owned(),
            column: wanted.to_owned(),
            matches: matches.iter().map(|&i| header[i].text.clone()).collect(),
        }),
    }
}

pub(super) fn texts(header: &[HeaderColumn]) -> Vec<String> {
    header.iter().map(|column| column.text.clone()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_taken_from_the_end_of_a_header() {
        let parts = |text| {
            let column = HeaderColumn::parse(text);
            (column.name, column.unit)
        };
        let some = |unit: &str| Some(unit.to_owned());
        assert_eq!(parts("T_7 [K]"), ("T_7".to_owned(), some("K")));
        assert_eq!(parts(" P 6(kPa) "), ("P 6".to_owned(), some("kPa")));
        assert_eq!(parts("x[0] [m]"), ("x[0]".to_owned(), some("m")));
        assert_eq!(parts("gyro[0]"), ("gyro[0]".to_owned(), None));
        assert_eq!(parts("gyro[12] [rad/s]"), ("gyro[12]".to_owned(), some("rad/s")));
        assert_eq!(parts("duty [1]"), ("duty".to_owned(), some("1")));
        assert_eq!(parts("duty[-]"), ("duty".to_owned(), some("-")));
        assert_eq!(parts("wf"), ("wf".to_owned(), None));
        assert_eq!(parts("[K]"), ("[K]".to_owned(), None));
    }
}
