//! One array in the format NPY, versions 1 to 3, as numpy's `format.py` describes it.

use std::io::{self, Read};

use super::{super::number::Number, literal::Literal};
use crate::{error::LogError, header::HeaderColumn, limit::Budget, recording::Topic};

/// First bytes.
pub(super) const MAGIC: &[u8] = b"\x93NUMPY";
/// Most bytes of a header; numpy's own limit is 10 000 characters.
const MOST_HEADER: u32 = 1 << 16;
/// Most columns that an array may have.
const MOST_COLUMNS: u64 = 4096;

/// Why an array is no part of the log.
#[derive(Debug)]
pub(super) enum NoArray {
    /// It is damaged.
    Unsound(String),
    /// It is something else than columns of numbers.
    Unfit(String),
    /// It is too large.
    Large(LogError),
}

impl From<LogError> for NoArray {
    fn from(error: LogError) -> Self {
        Self::Large(error)
    }
}

impl From<io::Error> for NoArray {
    fn from(error: io::Error) -> Self {
        Self::Unsound(match error.kind() {
            io::ErrorKind::UnexpectedEof => "the file ends too early".to_owned(),
            _ => format!("found: {error}"),
        })
    }
}

/// A part of each row: a name, the type of its numbers, and where it begins.
struct Field {
    name: String,
    number: Number,
    offset: usize,
}

/// Reads an array as columns: `name` for one dimension, `name[0]`, `name[1]`... for two, and one per field for
/// an array of records.
pub(super) fn read(name: &str, from: &mut dyn Read, left: &mut Budget) -> Result<Topic, NoArray> {
    let header = header(from)?;
    let unsound = || NoArray::Unsound("found a header that numpy does not write".to_owned());
    let (descr, shape) = (header.get("descr"), header.get("shape").and_then(Literal::numbers));
    let (Some(descr), Some(shape)) = (descr, shape) else { return Err(unsound()) };
    let is_fortran = header.get("fortran_order") == Some(&Literal::Truth(true));
    let unfit = |what: String| Err(NoArray::Unfit(what));
    let Some((fields, width)) = fields(name, descr) else {
        return unfit(format!("an array of type `{}`", shown(descr)));
    };
    let (rows, across) = match shape[..] {
        [] => return unfit("a single value".to_owned()),
        [rows] => (rows, None),
        // An array without rows claims no bytes, however many columns it has.
        [rows, across] if across.saturating_mul(fields.len() as u64) <= MOST_COLUMNS => {
            (rows, Some(across))
        }
        _ => return unfit(format!("an array of shape {shape:?}")),
    };
    let cells = rows.saturating_mul(across.unwrap_or(1));
    let numbers = cells.saturating_mul(fields.len() as u64);
    left.take(&format!("array `{name}`"), numbers.saturating_mul(8))?;
    let bytes = cells.saturating_mul(width as u64);
    left.take(&format!("array `{name}`"), bytes)?;
    let mut raw = Vec::new();
    // Grows with what is there, not with what the header claims.
    let found = from.take(bytes).read_to_end(&mut raw)?;
    if found as u64 != bytes {
        let found = format!("the array `{name}` ends after {found} of {bytes} bytes");
        return Err(NoArray::Unsound(found));
    }
    let mut topic = Topic::default();
    // All of it is in memory by now.
    let all = |n: u64| usize::try_from(n).unwrap_or(0);
    let (rows, across_all) = (all(rows), all(across.unwrap_or(1)));
    for field in &fields {
        for column in 0..across_all {
            let text = match across {
                None => field.name.clone(),
                Some(_) => format!("{}[{column}]", field.name),
            };
            let cell = |row: usize| {
                let cell = if is_fortran { column * rows + row } else { row * across_all + column };
                let begin = cell * width + field.offset;
                raw.get(begin..begin + field.number.bytes).unwrap_or_default()
            };
            let what = format!("array `{name}`");
            let values = field.number.values(&what, (0..rows).map(cell));
            topic.values.push(values.map_err(|error| left.refused(error))?);
            topic.columns.push(column_of(across, text));
        }
    }
    Ok(topic)
}

/// A name may bring its unit; an index in brackets is none.
fn column_of(across: Option<u64>, text: String) -> HeaderColumn {
    match across {
        None => HeaderColumn::parse(&text),
        Some(_) => HeaderColumn { name: text.clone(), text, unit: None },
    }
}

fn header(from: &mut dyn Read) -> Result<Literal, NoArray> {
    let mut begin = [0; 8];
    from.read_exact(&mut begin)?;
    if !begin.starts_with(MAGIC) {
        let found = format!("found `{}` at the beginning of an array", begin.escape_ascii());
        return Err(NoArray::Unsound(found));
    }
    let length = match begin[6] {
        1 => {
            let mut length = [0; 2];
            from.read_exact(&mut length)?;
            u32::from(u16::from_le_bytes(length))
        }
        2 | 3 => {
            let mut length = [0; 4];
            from.read_exact(&mut length)?;
            u32::from_le_bytes(length)
        }
        other => return Err(NoArray::Unsound(format!("found version {other} of NPY"))),
    };
    if length > MOST_HEADER {
        let found = format!("found a header of {length} bytes, more than {MOST_HEADER}");
        return Err(NoArray::Unsound(found));
    }
    let mut text = Vec::new();
    if from.take(u64::from(length)).read_to_end(&mut text)? as u64 != u64::from(length) {
        return Err(io::Error::from(io::ErrorKind::UnexpectedEof).into());
    }
    let unsound = || NoArray::Unsound("found a header that numpy does not write".to_owned());
    Literal::parse(&String::from_utf8_lossy(&text)).ok_or_else(unsound)
}

/// The parts of a row, and its length in bytes; nothing for what is no number.
fn fields(name: &str, descr: &Literal) -> Option<(Vec<Field>, usize)> {
    if let Some(text) = descr.text() {
        let number = Number::parse(text)?;
        return Some((vec![Field { name: name.to_owned(), number, offset: 0 }], number.bytes));
    }
    let mut fields = Vec::new();
    let mut offset = 0;
    for field in descr.list()? {
        let [name, kind] = field.list()? else { return None };
        let number = Number::parse(kind.text()?)?;
        fields.push(Field { name: name.text()?.to_owned(), number, offset });
        offset += number.bytes;
    }
    (!fields.is_empty()).then_some((fields, offset))
}

fn shown(descr: &Literal) -> String {
    descr.text().map_or_else(|| "records".to_owned(), str::to_owned)
}
