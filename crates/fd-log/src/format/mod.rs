//! The formats that can be read: one list, from the name of a file to a source.

mod csv;
mod ndjson;

use std::{fs::File, path::Path};

pub use self::{csv::CsvSource, ndjson::NdjsonSource};
use crate::{
    error::LogError,
    map::LogMap,
    source::{LogSource, cannot_read},
};

/// A format of log files.
#[derive(Clone, Copy, Debug)]
pub struct LogFormat {
    /// Name, as people say it.
    pub name: &'static str,
    /// Endings of file names, in lower case.
    pub extensions: &'static [&'static str],
    /// Opens a file that is there; the text is its name for errors.
    open: Open,
}

/// Opens a file as a table.
type Open = fn(&str, File, &LogMap) -> Result<Box<dyn LogSource>, LogError>;

/// All formats. The first one is meant where the name of a file ends in something else.
pub const FORMATS: &[LogFormat] = &[
    LogFormat {
        name: "CSV",
        extensions: &["csv", "tsv", "txt"],
        open: |file, from, map| Ok(Box::new(CsvSource::new(file, from, map)?)),
    },
    LogFormat {
        name: "NDJSON",
        extensions: &["ndjson", "jsonl"],
        open: |file, from, _| Ok(Box::new(NdjsonSource::new(file, from)?)),
    },
];

/// The format of a file, by the ending of its name.
///
/// ```
/// assert_eq!(fd_log::format_of("runs/monday.jsonl").name, "NDJSON");
/// assert_eq!(fd_log::format_of("runs/monday.log").name, "CSV");
/// ```
#[must_use]
pub fn format_of(path: impl AsRef<Path>) -> &'static LogFormat {
    let extension = path.as_ref().extension().unwrap_or_default().to_string_lossy().to_lowercase();
    let known = FORMATS.iter().find(|format| format.extensions.contains(&extension.as_str()));
    known.unwrap_or(&FORMATS[0])
}

/// Opens a log file as a table.
///
/// # Errors
///
/// Returns an error when the file cannot be opened, or does not begin as its format does.
pub fn open(path: impl AsRef<Path>, map: &LogMap) -> Result<Box<dyn LogSource>, LogError> {
    let path = path.as_ref();
    let file = path.display().to_string();
    let from = File::open(path).map_err(|error| cannot_read(&file, error.kind()))?;
    (format_of(path).open)(&file, from, map)
}
