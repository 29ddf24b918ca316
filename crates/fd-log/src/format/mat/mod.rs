//! MAT-files, "MAT-File Format" (MathWorks): version 5 is what MATLAB saves up to version 7, and scipy writes; version 4
//! is older, and what Modelica tools write ([`v4`]).
//!
//! A vector, lying or standing, is a column under its name; a matrix has columns `name[0]`, `name[1]`..., and the fields
//! of a struct are `log.u`. What has equally many rows is one table. Texts, cells, struct arrays, sparse matrices and
//! objects (`table`, `timeseries`) are named and left: save them as plain vectors.

mod damaged;
mod element;
mod name;
mod numbers;
mod v4;

use std::{fs::File, io::Read};

use self::{
    damaged::damaged,
    element::{Element, Elements},
    name::text,
};
use crate::{error::LogError, limit::Budget, recording::Recording};

/// Text, where subsystem data begin, version, order of bytes.
const HEADER: usize = 128;
/// Structs within structs.
const DEEPEST: usize = 16;
/// Classes of arrays.
const STRUCT: u8 = 2;
/// The first class of numbers.
const DOUBLE: u8 = 6;
/// The last class of numbers.
const UINT64: u8 = 15;
/// A class of its own (`table`, `timeseries`, `string`); has no dimensions.
const OPAQUE: u8 = 17;
/// Where an array says that it is complex.
const COMPLEX: u8 = 0x08;

/// A MAT-file.
pub(super) fn read(file: &str, from: File) -> Result<Recording, LogError> {
    let mut left = Budget::of_file(file, &from);
    let raw = whole(file, from, &mut left)?;
    let recording = Recording { file: file.to_owned(), ..Recording::default() };
    let mut reader = Reader { recording, left };
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
    recording.with_columns("columns of numbers")
}

/// A MAT-file of version 4.
pub(super) fn read_v4(file: &str, from: File) -> Result<Recording, LogError> {
    let mut left = Budget::of_file(file, &from);
    let raw = whole(file, from, &mut left)?;
    v4::read(file, &raw, &mut left)
}

fn whole(file: &str, from: File, left: &mut Budget) -> Result<Vec<u8>, LogError> {
    let length = from.metadata().map_or(0, |about| about.len());
    left.take("the file", length)?;
    let mut raw = Vec::new();
    let read = from.take(length).read_to_end(&mut raw);
    read.map_err(|error| damaged(file, &format!("found: {error}")))?;
    Ok(raw)
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
        let flags = part("flags")?;
        // The class is the lowest byte, and flags the one above.
        let [class, flags, ..] =
            flags.words(is_big_endian).first().map_or([0; 4], |w| w.to_le_bytes());
        let shape = if class == OPAQUE { None } else { Some(part("dimensions")?) };
        let name = part("name")?;
        let own = String::from_utf8_lossy(name.data).into_owned();
        let name = match (within, own.as_str()) {
            ("", own) => own.to_owned(),
            (within, "") => within.to_owned(),
            (within, own) => format!("{within}.{own}"),
        };
        // What objects are made of stands behind all arrays, without a name.
        if name.is_empty() {
            return Ok(());
        }
        let shape = shape.map_or(Vec::new(), |shape| shape.words(is_big_endian));
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
                    STRUCT => {
                        format!(
                            "{} structs",
                            shape.iter().map(|n| u64::from(*n)).fold(1, u64::saturating_mul)
                        )
                    }
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
        let Self { recording, left } = self;
        let file = recording.file.clone();
        let Some(number) = values.number(is_big_endian) else {
            let found = format!("found numbers of the unknown type {} in `{name}`", values.kind);
            return Err(damaged(&file, &found));
        };
        let shape: Vec<u64> = shape.iter().map(|n| u64::from(*n)).collect();
        numbers::add(recording, name, &shape, &mut |(rows, across)| {
            let cells = rows.saturating_mul(across);
            let bytes = cells.saturating_mul(number.bytes as u64);
            if bytes != values.data.len() as u64 {
                let found =
                    format!("the array `{name}` has {} of {bytes} bytes", values.data.len());
                return Err(damaged(&file, &found));
            }
            let what = format!("array `{name}`");
            left.take(&what, cells.saturating_mul(8))?;
            let values = number.values(&what, values.data.chunks(number.bytes));
            values.map_err(|error| left.refused(error))
        })
    }
}
