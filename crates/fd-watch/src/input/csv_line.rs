//! A line of CSV. A cell with a line break in it is not understood: a stream has lines.

use std::borrow::Cow;

/// The cells of a line.
pub(super) fn cells(line: &str, delimiter: char) -> Result<Vec<Cow<'_, str>>, String> {
    if !line.contains('"') {
        return Ok(line.split(delimiter).map(Cow::Borrowed).collect());
    }
    let Ok(delimiter) = u8::try_from(delimiter) else {
        return Err(format!("`{delimiter}` cannot separate quoted cells"));
    };
    if line.matches('"').count() % 2 == 1 {
        return Err("a quote is not closed in this line".to_owned());
    }
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .delimiter(delimiter)
        .from_reader(line.as_bytes());
    let mut record = csv::StringRecord::new();
    reader.read_record(&mut record).map_err(|error| error.to_string())?;
    Ok(record.iter().map(|cell| Cow::Owned(cell.to_owned())).collect())
}

/// The most frequent separator of a header.
pub(super) fn separator(header: &str) -> char {
    let count = |c: char| header.matches(c).count();
    // Of equally frequent ones the first.
    [';', '\t'].into_iter().fold(',', |most, c| if count(most) < count(c) { c } else { most })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quoted_cells_may_hold_the_separator() {
        assert_eq!(cells(r#"1,"a,""b""",2"#, ',').unwrap(), ["1", r#"a,"b""#, "2"]);
        assert_eq!(cells("1;2;", ';').unwrap(), ["1", "2", ""]);
        assert!(cells(r#"1,"a"#, ',').is_err());
        assert_eq!([separator("a;b,c;d"), separator("a"), separator("a\tb")], [';', ',', '\t']);
    }
}
