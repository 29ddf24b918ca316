//! Cells: text in UTF-8 or Windows-1252, and numbers as people write them.

use std::borrow::Cow;

use crate::error::LogError;

/// Most bytes of what is no text that a message shows.
const MOST_SHOWN: usize = 24;

/// What Windows-1252 has from 0x80 to 0x9f; zero where it has nothing.
#[rustfmt::skip]
const WINDOWS_1252: [u32; 32] = [
    0x20ac, 0, 0x201a, 0x0192, 0x201e, 0x2026, 0x2020, 0x2021, 0x02c6, 0x2030, 0x0160, 0x2039, 0x0152, 0, 0x017d, 0,
    0, 0x2018, 0x2019, 0x201c, 0x201d, 0x2022, 0x2013, 0x2014, 0x02dc, 0x2122, 0x0161, 0x203a, 0x0153, 0, 0x017e, 0x0178,
];

/// The text of a cell: UTF-8, else Windows-1252, else an error.
pub(super) fn text<'a>(file: &str, row: u64, cell: &'a [u8]) -> Result<Cow<'a, str>, LogError> {
    let utf8 = std::str::from_utf8(cell).ok().filter(|text| !text.contains('\0'));
    utf8.map(Cow::Borrowed).or_else(|| Some(Cow::Owned(windows_1252(cell)?))).ok_or_else(|| {
        let shown = &cell[..cell.len().min(MOST_SHOWN)];
        let more = if shown.len() < cell.len() { "..." } else { "" };
        let found = format!("`{}{more}`", shown.escape_ascii());
        LogError::NotText { file: file.to_owned(), row, found }
    })
}

/// Text of Windows-1252; nothing where a byte is no character of it, or a control character.
fn windows_1252(bytes: &[u8]) -> Option<String> {
    let character = |byte: &u8| match byte {
        b'\t' | 0x20..=0x7e | 0xa0..=0xff => Some(char::from(*byte)),
        0x80..=0x9f => {
            char::from_u32(WINDOWS_1252[usize::from(byte - 0x80)]).filter(|c| *c != '\0')
        }
        _ => None,
    };
    bytes.iter().map(character).collect()
}

/// Whether a cell says that there is no value.
pub(super) fn is_missing(text: &str) -> bool {
    text.is_empty() || ["nan", "na", "n/a", "null"].iter().any(|m| text.eq_ignore_ascii_case(m))
}

/// A finite number, with a decimal point or a decimal comma; thousands may be set apart.
///
/// `1,000` with a decimal point is none: it may be a thousand, or one with a comma.
pub(super) fn number(text: &str, decimal_comma: bool) -> Option<f64> {
    let finite = |text: &str| text.parse().ok().filter(|number: &f64| number.is_finite());
    let (decimal, thousands) = if decimal_comma { (',', '.') } else { ('.', ',') };
    let (whole, rest) = text.split_once(decimal).unwrap_or((text, ""));
    let has_rest = whole.len() < text.len();
    let is_set_apart = |by: &char| {
        let digits = whole.trim_start_matches(['+', '-']);
        let mut groups = digits.split(*by);
        let first = groups.next().is_some_and(|first| (1..=3).contains(&first.len()));
        first
            && digits.contains(*by)
            && groups.all(|group| group.len() == 3)
            && digits.chars().all(|c| c == *by || c.is_ascii_digit())
    };
    // Blanks, and what stands for one where a line must not break; apostrophes are Swiss.
    let set_apart = [thousands, ' ', '\u{a0}', '\u{202f}', '\''].into_iter().find(is_set_apart);
    match set_apart {
        Some(by) if by != ',' || has_rest => finite(&format!("{}.{rest}", whole.replace(by, ""))),
        Some(_) => None,
        None if decimal_comma => finite(&text.replacen(',', ".", 1)),
        None => finite(text),
    }
}

/// What a cell says about decimal signs: a comma, a point, or nothing for sure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DecimalSign {
    Comma,
    Point,
    Unknown,
}

/// The decimal sign of a cell. `1,250` may be a thousand, `0,125` and `1,25` are none.
pub(super) fn decimal_sign(text: &str) -> DecimalSign {
    // Three digits behind a sign that stands once may be thousands.
    let may_be_thousands = |sign: char| {
        let (whole, rest) = text.split_once(sign).unwrap_or_default();
        let whole = whole.trim_start_matches(['+', '-']);
        rest.len() == 3 && (1..=3).contains(&whole.len()) && whole != "0"
    };
    let shows = |sign: char| text.contains(sign) && !may_be_thousands(sign);
    match (number(text, true), number(text, false)) {
        (Some(_), None) if shows(',') => DecimalSign::Comma,
        (_, Some(_)) if shows('.') => DecimalSign::Point,
        _ => DecimalSign::Unknown,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_as_people_write_them() {
        for (text, comma, expected) in [
            ("1.5", false, Some(1.5)),
            ("1,5", false, None),
            ("1,000", false, None),
            ("1,000.5", false, Some(1000.5)),
            ("-1,234,567.5", false, Some(-1_234_567.5)),
            ("1 234.5", false, Some(1234.5)),
            ("1,5", true, Some(1.5)),
            ("1.5", true, Some(1.5)),
            ("1.000,5", true, Some(1000.5)),
            ("1.000.000", true, Some(1e6)),
            ("1\u{202f}000,5", true, Some(1000.5)),
            ("1'000.5", false, Some(1000.5)),
            ("1,5e-3", true, Some(1.5e-3)),
            ("1,2,3", true, None),
            ("1.00,5", true, None),
            ("inf", false, None),
            ("", false, None),
        ] {
            assert_eq!(number(text, comma), expected, "{text} {comma}");
        }
    }

    #[test]
    fn only_what_is_no_thousand_shows_the_sign() {
        for (text, sign) in [
            ("1,25", DecimalSign::Comma),
            ("0,125", DecimalSign::Comma),
            ("1.000,5", DecimalSign::Comma),
            ("1,250", DecimalSign::Unknown),
            ("1.5", DecimalSign::Point),
            ("1.000", DecimalSign::Unknown),
            ("1,000.5", DecimalSign::Point),
            ("7", DecimalSign::Unknown),
            ("on", DecimalSign::Unknown),
        ] {
            assert_eq!(decimal_sign(text), sign, "{text}");
        }
    }

    #[test]
    fn degrees_of_windows_are_degrees() {
        assert_eq!(text("f", 1, b"T [\xb0C]").unwrap(), "T [°C]");
        assert_eq!(text("f", 1, b"\x80").unwrap(), "€");
        assert!(text("f", 1, b"\xb0\x01").is_err() && text("f", 1, b"\x81").is_err());
    }
}
