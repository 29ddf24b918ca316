//! Logs as files; the formats are described in `docs/formats.md`.
//!
//! | What | Read | Write |
//! |------|------|-------|
//! | record | [`read_log`] with a [`LogMap`] | [`write_log`] |
//! | huge log, row by row | [`LogReader`] | |
//!
//! A format is one file that implements [`LogSource`], and one line in the list of [`FORMATS`].

mod columns;
mod csv;
mod error;
mod format;
mod header;
mod map;
mod ndjson;
mod reader;
mod source;
mod writer;

pub use self::{
    csv::CsvSource,
    error::LogError,
    format::{FORMATS, LogFormat, format_of, open},
    header::HeaderColumn,
    map::{ColumnMap, LogMap, RowRule, TimeMap},
    ndjson::NdjsonSource,
    reader::{Log, LogReader, LogRow, read_log, read_log_from},
    source::LogSource,
    writer::{write_log, write_log_to},
};

#[cfg(test)]
mod tests;
