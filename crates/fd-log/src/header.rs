//! The header of a log: names and units of columns.

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
    /// Splits `T_7 [K]` and `T_7 (K)` into name and unit.
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
            nearest: nearest(header, wanted),
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

/// The column most like `wanted`, if it takes few changes to get from one to the other.
fn nearest(header: &[HeaderColumn], wanted: &str) -> Option<String> {
    let wanted = wanted.to_lowercase();
    let distance = |column: &HeaderColumn| edit_distance(&column.name.to_lowercase(), &wanted);
    let (changes, column) =
        header.iter().map(|column| (distance(column), column)).min_by_key(|(d, _)| *d)?;
    (changes <= (wanted.chars().count() / 3).max(1)).then(|| column.name.clone())
}

/// Insertions, deletions and replacements between two texts (Levenshtein 1966).
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, from) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, to) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(from != *to);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
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
        assert_eq!(parts("wf"), ("wf".to_owned(), None));
        assert_eq!(parts("[K]"), ("[K]".to_owned(), None));
    }

    #[test]
    fn edit_distances() {
        for (a, b, distance) in [("kitten", "sitting", 3), ("", "ab", 2), ("wf", "wf", 0)] {
            assert_eq!(edit_distance(a, b), distance);
        }
    }
}
