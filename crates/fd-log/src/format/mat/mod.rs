//! MAT-files of version 5, "MAT-File Format" (MathWorks): what MATLAB saves up to version 7, and scipy writes.
//!
//! A vector, lying or standing, is a column under its name; a matrix has columns `name[0]`, `name[1]`..., and the fields
//! of a struct are `log.u`. What has equally many rows is one table. Texts, cells, struct arrays, sparse matrices and
//! objects (`table`, `timeseries`) are named and left: save them as plain vectors.

mod element;

use std::{fs::File, io::Read};

use self::element::{Element, Elements};
use crate::{
    error::LogError,
    header::HeaderColumn,
    limit::Budget,
    recording::{Recording, Topic},
};

/// Text, where subsystem data begin, version, order of bytes.
const HEADER: usize = 128;
/// Structs within structs.
const DEEPEST: usize = 16;
/// Most columns that a matrix may have.
const MOST_COLUMNS: u32 = 4096;
/// Classes of arrays.
const STRUCT: u8 = 2;
/// The first class of numbers.
const DOUBLE: u8 = 6;
/// The last class of numbers.
const UINT64: u8 = 15;
/// Where an array says that it is complex.
const COMPLEX: u8 = 0x08;

/// A MAT-file.
pub(super) fn read(file: &str, from: File) -> Result<Recording, LogError> {
    let recording = Recording { file: file.to_owned(), ..Recording::default() };
    let mut reader = Reader { recording, left: Budget::new(file) };
    let length = from.metadata().map_or(0, |about| about.len());
    reader.left.take("the file", length)?;
    let mut raw = Vec::new();
    from.take(length)
        .read_to_end(&mut raw)
        .map_err(|error| damaged(file, &format!("found: {error}")))?;
    let is_big_endian = match raw.get(HEADER - 2..HEADER) {
        Some(b"IM") => false,
        Some(b"MI") => true,
        _ => return Err(damaged(file, "found no mark of the order of bytes")),
    };
    let mut elements = Elements::new(raw.get(HEADER..).unwrap_or_default(), is_big_endian);
    while let Some(element) = elements.next_or(|what| damaged(file, what))? {
        match element.kind {
            Element::COMPRESSED => {
                let inner = element.unpacked(&mut reader.left, file)?;
                let mut inner = Elements::new(&inner, is_big_endian);
                if let Some(element) = inner.next_or(|what| damaged(file, what))? {
                    reader.matrix(&element, "", is_big_endian, 0)?;
                }
            }
            _ => reader.matrix(&element, "", is_big_endian, 0)?,
        }
    }
    let Reader { recording, .. } = reader;
    if recording.topics.is_empty() {
        let (expected, found) = ("columns of numbers", format!("found {:?}", recording.unfit));
        return Err(LogError::NoLog { file: file.to_owned(), expected, found });
    }
    Ok(recording)
}

/// What is read, and what there is still room for.
struct Reader {
    recording: Recording,
    left: Budget,
}

impl Reader {
    /// An array: flags, dimensions, name, and what its class brings.
    fn matrix(
        &mut self,
        element: &Element<'_>,
        within: &str,
        is_big_endian: bool,
        depth: usize,
    ) -> Result<(), LogError> {
        if element.kind != Element::MATRIX || element.data.is_empty() {
            return Ok(());
        }
        let mut parts = Elements::new(element.data, is_big_endian);
        let file = self.recording.file.clone();
        let mut part = |what: &str| {
            let found = format!("found an array without its {what}");
            parts.next_or(|what| damaged(&file, what))?.ok_or_else(|| damaged(&file, &found))
        };
        let (flags, shape, name) = (part("flags")?, part("dimensions")?, part("name")?);
        // The class is the lowest byte, and flags the one above.
        let [class, flags, ..] =
            flags.words(is_big_endian).first().map_or([0; 4], |w| w.to_le_bytes());
        let own = String::from_utf8_lossy(name.data).into_owned();
        let name = match (within, own.as_str()) {
            ("", own) => own.to_owned(),
            (within, "") => within.to_owned(),
            (within, own) => format!("{within}.{own}"),
        };
        let shape = shape.words(is_big_endian);
        match class {
            STRUCT if shape.iter().all(|n| *n == 1) && depth < DEEPEST => {
                let (length, names) = (part("lengths")?, part("names of fields")?);
                let length = length.words(is_big_endian).first().map_or(0, |n| *n as usize);
                let names: Vec<String> = names.data.chunks(length.max(1)).map(text).collect();
                for field in names {
                    let value = part("fields")?;
                    self.matrix(&value, &format!("{name}.{field}"), is_big_endian, depth + 1)?;
                }
                Ok(())
            }
            DOUBLE..=UINT64 if flags & COMPLEX == 0 => {
                let values = part("numbers")?;
                self.numbers(&name, &shape, &values, is_big_endian)
            }
            _ => {
                let why = match class {
                    DOUBLE..=UINT64 => "complex numbers".to_owned(),
                    STRUCT => format!("structs of shape {shape:?}"),
                    1 => "cells".to_owned(),
                    4 => "text".to_owned(),
                    5 => "a sparse matrix".to_owned(),
                    _ => "an object".to_owned(),
                };
                self.recording.unfit.push((name, why));
                Ok(())
            }
        }
    }

    fn numbers(
        &mut self,
        name: &str,
        shape: &[u32],
        values: &Element<'_>,
        is_big_endian: bool,
    ) -> Result<(), LogError> {
        let (rows, across) = match *shape {
            [1, n] | [n, 1] if n != 1 => (u64::from(n), None),
            [rows, across] if rows != 1 && across <= MOST_COLUMNS => {
                (u64::from(rows), Some(u64::from(across)))
            }
            _ => {
                let is_single = shape.iter().all(|n| *n == 1);
                let array = || format!("an array of shape {shape:?}");
                let why = if is_single { "a single value".to_owned() } else { array() };
                self.recording.unfit.push((name.to_owned(), why));
                return Ok(());
            }
        };
        let Some(number) = values.number(is_big_endian) else {
            let found = format!("found numbers of the unknown type {} in `{name}`", values.kind);
            return Err(damaged(&self.recording.file, &found));
        };
        let cells = rows.saturating_mul(across.unwrap_or(1));
        let bytes = cells.saturating_mul(number.bytes as u64);
        if bytes != values.data.len() as u64 {
            let found = format!("the array `{name}` has {} of {bytes} bytes", values.data.len());
            return Err(damaged(&self.recording.file, &found));
        }
        self.left.take(&format!("array `{name}`"), cells.saturating_mul(8))?;
        let mut topic = Topic::default();
        // Column by column, which is how MATLAB stores them.
        let column_bytes = usize::try_from(rows).unwrap_or(0).saturating_mul(number.bytes);
        for (i, column) in values.data.chunks(column_bytes.max(1)).enumerate() {
            topic.values.push(number.values(column.chunks(number.bytes)));
            let index = across.map_or(String::new(), |_| format!("[{i}]"));
            topic.columns.push(HeaderColumn::parse(&format!("{name}{index}")));
        }
        if !topic.columns.is_empty() {
            self.recording.add_table(topic);
        }
        Ok(())
    }
}

fn damaged(file: &str, found: &str) -> LogError {
    LogError::Damaged { file: file.to_owned(), format: "MAT", found: found.to_owned() }
}

/// A name that is filled up with zeros.
fn text(raw: &[u8]) -> String {
    let end = raw.iter().position(|byte| *byte == 0).unwrap_or(raw.len());
    String::from_utf8_lossy(&raw[..end]).into_owned()
}
