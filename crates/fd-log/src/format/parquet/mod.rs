//! Parquet: columns of numbers and times, one by one or as lists of equal length.
//!
//! A column of lists becomes columns `name[0]`, `name[1]`...; times (`timestamp`) become seconds since the first of
//! them. Texts, decimals and lists of lists are named and left. Read by the crate `parquet` without Arrow.

mod lerobot;
mod level;

use std::{
    fs::File,
    panic::{AssertUnwindSafe, catch_unwind},
    path::Path,
};

use parquet::{
    basic::{ConvertedType, LogicalType, TimeUnit, Type},
    column::reader::{ColumnReader, ColumnReaderImpl},
    data_type::DataType,
    errors::ParquetError,
    file::reader::{FileReader, SerializedFileReader},
    schema::types::ColumnDescriptor,
};

pub(super) use self::lerobot::{is_dataset, read, read_dataset};
use self::level::{Leaf, MOST_COLUMNS};
use crate::{
    error::LogError,
    header::HeaderColumn,
    limit::Budget,
    recording::{Recording, Topic},
};

/// Rows that are decoded at a time.
const BATCH: usize = 1 << 14;

/// Reads the columns of a file whose names are asked for.
fn read_plain(
    file: &str,
    from: File,
    left: &mut Budget,
    wanted: &mut dyn FnMut(&str) -> bool,
) -> Result<Recording, LogError> {
    let damaged =
        |found: String| LogError::Damaged { file: file.to_owned(), format: "Parquet", found };
    // What the crate does with a damaged file is an error for all that was tried; should it ever panic
    // instead, that is an error of this file too. Nothing outlives the call.
    let columns = catch_unwind(AssertUnwindSafe(|| read_columns(file, from, left, wanted)));
    match columns {
        Ok(Ok(recording)) => Ok(recording),
        Ok(Err(Failed::Parquet(error))) => Err(damaged(format!("found: {error}"))),
        Ok(Err(Failed::Log(error))) => Err(error),
        Err(_) => Err(damaged("found something that its reader does not understand".to_owned())),
    }
}

enum Failed {
    Parquet(ParquetError),
    Log(LogError),
}

impl From<ParquetError> for Failed {
    fn from(error: ParquetError) -> Self {
        Self::Parquet(error)
    }
}

impl From<LogError> for Failed {
    fn from(error: LogError) -> Self {
        Self::Log(error)
    }
}

fn read_columns(
    file: &str,
    from: File,
    left: &mut Budget,
    wanted: &mut dyn FnMut(&str) -> bool,
) -> Result<Recording, Failed> {
    let reader = SerializedFileReader::new(from)?;
    let mut recording = Recording { file: file.to_owned(), ..Recording::default() };
    let mut topic = Topic::default();
    let mut rows = None;
    for (index, descr) in
        reader.metadata().file_metadata().schema_descr().columns().iter().enumerate()
    {
        let name = name_of(descr);
        if !wanted(&name) {
            continue;
        }
        let Some(scale) = Scale::of(descr) else {
            recording.unfit.push((name, format!("values of type {}", kind_of(descr))));
            continue;
        };
        let mut leaf = Leaf::new(descr.max_def_level(), descr.max_rep_level() > 0);
        let mut first = None;
        for group in 0..reader.num_row_groups() {
            let column = reader.get_row_group(group)?.get_column_reader(index)?;
            let left = &mut *left;
            match column {
                ColumnReader::BoolColumnReader(c) => {
                    pull(c, &mut leaf, left, &name, |v| f64::from(u8::from(*v)))?;
                }
                ColumnReader::Int32ColumnReader(c) => {
                    pull(c, &mut leaf, left, &name, |v| {
                        scale.seconds_or_number(i64::from(*v), &mut first)
                    })?;
                }
                ColumnReader::Int64ColumnReader(c) => {
                    pull(c, &mut leaf, left, &name, |v| scale.seconds_or_number(*v, &mut first))?;
                }
                ColumnReader::Int96ColumnReader(c) => {
                    let nanos = Scale::Date(1e-9);
                    pull(c, &mut leaf, left, &name, |v| {
                        nanos.seconds_or_number(v.to_nanos(), &mut first)
                    })?;
                }
                ColumnReader::FloatColumnReader(c) => {
                    pull(c, &mut leaf, left, &name, |v| f64::from(*v))?;
                }
                ColumnReader::DoubleColumnReader(c) => pull(c, &mut leaf, left, &name, |v| *v)?,
                ColumnReader::ByteArrayColumnReader(_)
                | ColumnReader::FixedLenByteArrayColumnReader(_) => {}
            }
        }
        let expected = *rows.get_or_insert(leaf.rows());
        if leaf.rows() != expected {
            let (file, found) = (file.to_owned(), leaf.rows());
            return Err(LogError::Ragged { file, column: name, expected, found }.into());
        }
        left.take(&format!("column `{name}`"), 8 * leaf.missing())?;
        for (text, values) in leaf.into_columns(&name) {
            // A name that ends in an index brings no unit.
            let header = if text == name {
                HeaderColumn::parse(&text)
            } else {
                HeaderColumn { name: text.clone(), text, unit: None }
            };
            topic.columns.push(header);
            topic.values.push(values);
        }
    }
    if topic.columns.is_empty() {
        return Ok(recording.with_columns("columns of numbers")?);
    }
    recording.topics.push(topic);
    Ok(recording)
}

/// Reads a column of one row group.
fn pull<T: DataType>(
    mut column: ColumnReaderImpl<T>,
    leaf: &mut Leaf,
    left: &mut Budget,
    name: &str,
    mut number: impl FnMut(&T::T) -> f64,
) -> Result<(), Failed> {
    let (mut def, mut rep, mut values) = (Vec::new(), Vec::new(), Vec::new());
    loop {
        def.clear();
        rep.clear();
        values.clear();
        let (records, _, levels) =
            column.read_records(BATCH, Some(&mut def), Some(&mut rep), &mut values)?;
        if levels == 0 {
            return Ok(());
        }
        left.take(&format!("column `{name}`"), 8 * levels.max(records) as u64)?;
        let mut numbers = values.iter().map(&mut number);
        let missing = leaf.add(levels, &def, &rep, &mut numbers);
        if leaf.width() > MOST_COLUMNS {
            let found = format!("found lists of more than {MOST_COLUMNS} numbers in `{name}`");
            return Err(ParquetError::General(found).into());
        }
        left.take(&format!("column `{name}`"), 8 * missing)?;
    }
}

/// What whole numbers of a column stand for.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Scale {
    Signed,
    Unsigned,
    /// Instants: ticks of so many seconds, from the first on.
    Date(f64),
    /// Times of the day, in ticks of so many seconds.
    Time(f64),
}

impl Scale {
    /// Nothing for what is no number.
    fn of(descr: &ColumnDescriptor) -> Option<Self> {
        let tick = |unit: &TimeUnit| match unit {
            TimeUnit::MILLIS => 1e-3,
            TimeUnit::MICROS => 1e-6,
            TimeUnit::NANOS => 1e-9,
        };
        let is_number =
            !matches!(descr.physical_type(), Type::BYTE_ARRAY | Type::FIXED_LEN_BYTE_ARRAY);
        if !is_number || descr.max_rep_level() > 1 {
            return None;
        }
        match descr.logical_type_ref() {
            Some(LogicalType::Timestamp(stamp)) => Some(Self::Date(tick(&stamp.unit))),
            Some(LogicalType::Time(time)) => Some(Self::Time(tick(&time.unit))),
            Some(LogicalType::Date) => Some(Self::Date(86_400.0)),
            Some(LogicalType::Decimal(_)) => None,
            Some(LogicalType::Integer(kind)) if !kind.is_signed => Some(Self::Unsigned),
            Some(_) => Some(Self::Signed),
            // Older writers know only these.
            None => match descr.converted_type() {
                ConvertedType::TIMESTAMP_MILLIS => Some(Self::Date(1e-3)),
                ConvertedType::TIMESTAMP_MICROS => Some(Self::Date(1e-6)),
                ConvertedType::DECIMAL => None,
                _ => Some(Self::Signed),
            },
        }
    }

    #[allow(clippy::cast_sign_loss, reason = "the bits are those of an unsigned number")]
    fn seconds_or_number(self, ticks: i64, first: &mut Option<i64>) -> f64 {
        match self {
            Self::Signed => ticks as f64,
            Self::Unsigned => ticks as u64 as f64,
            Self::Time(tick) => ticks as f64 * tick,
            // Subtracted as whole numbers: nanoseconds since 1970 have no room in an f64.
            Self::Date(tick) => ticks.wrapping_sub(*first.get_or_insert(ticks)) as f64 * tick,
        }
    }
}

/// The path of a column, without the steps that only say that it is a list.
fn name_of(descr: &ColumnDescriptor) -> String {
    let parts = descr.path().parts();
    let kept =
        if descr.max_rep_level() > 0 { parts.len().saturating_sub(2).max(1) } else { parts.len() };
    parts[..kept.min(parts.len())].join(".")
}

fn name_of_file(path: &Path) -> String {
    path.display().to_string()
}

fn kind_of(descr: &ColumnDescriptor) -> String {
    let logical = descr.logical_type_ref().map(|logical| format!("{logical:?}"));
    let kind = logical.unwrap_or_else(|| descr.physical_type().to_string());
    if descr.max_rep_level() > 1 { format!("lists of lists of {kind}") } else { kind }
}
