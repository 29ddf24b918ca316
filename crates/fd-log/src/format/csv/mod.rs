//! Text with one row per line: columns between commas, semicolons or tabs, a header with names and units.

mod cell;
mod dialect;
mod head;
mod utf16;

use std::io::{self, Cursor, Read};

use csv::ByteRecord;

use self::{
    cell::{is_missing, number, text},
    dialect::Dialect,
    head::{Head, LineCounter, Whole},
};
use super::bounded::check_columns;
use crate::{
    date::{Dates, When},
    error::LogError,
    header::HeaderColumn,
    map::LogMap,
    source::{LogSource, cannot_read},
};

/// A CSV file, in the memory of one row.
#[derive(Debug)]
pub struct CsvSource<R> {
    file: String,
    csv: csv::Reader<Whole<R>>,
    cells: ByteRecord,
    row: u64,
    lines: LineCounter,
    dialect: Dialect,
    sample_time: Option<f64>,
    dates: Dates,
}

impl<R: Read> CsvSource<R> {
    /// Reads the header; `file` is the name for errors. Of the map, separators and the order of dates matter here.
    ///
    /// What the map does not say is found from the first 64 KiB: the separator, lines before the header, units in the
    /// line behind it, a decimal comma, columns of dates. The text is UTF-8, UTF-16 with a mark, or Windows-1252.
    ///
    /// ```
    /// use fd_log::{CsvSource, LogMap, LogSource};
    ///
    /// let text = "Logger 7\nt;y [K]\n0;5,5\n";
    /// let mut csv = CsvSource::new("run.csv", text.as_bytes(), &LogMap::default())?;
    /// assert_eq!(csv.columns()[1].unit.as_deref(), Some("K"));
    /// assert_eq!(csv.next_row()?, Some(3));
    /// assert_eq!(csv.number(1)?, 5.5);
    /// # Ok::<(), fd_log::LogError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when the file is empty, is no text, or was written in an unknown version.
    pub fn new(file: &str, from: R, map: &LogMap) -> Result<Self, LogError> {
        let (mut head, rest) = Head::read(file, from)?;
        let line = head.block.split(|byte| *byte == b'\n').next().unwrap_or_default();
        // Of whatever separator.
        let most = b",;\t".map(|separator| line.split(|byte| *byte == separator).count());
        check_columns(file, most.into_iter().max().unwrap_or(1))?;
        let dialect = Dialect::find(file, &head, map)?;
        let (bytes, lines) = dialect.skipped;
        head.block.drain(..bytes);
        let first = head.block.split_inclusive(|byte| *byte == b'\n').next();
        let crlf = first.is_some_and(|line| line.ends_with(b"\r\n"));
        let mut csv = csv::ReaderBuilder::new()
            .delimiter(dialect.delimiter)
            .flexible(true)
            .has_headers(false)
            .from_reader(Cursor::new(head.block).chain(rest));
        let mut cells = ByteRecord::new();
        for _ in 0..=usize::from(dialect.has_units) {
            csv.read_byte_record(&mut cells).map_err(|error| csv_error(file, &error))?;
        }
        let before_header = head.lines_before + lines;
        Ok(Self {
            file: file.to_owned(),
            csv,
            cells,
            row: before_header + 1,
            lines: LineCounter { before_header, crlf },
            dialect,
            sample_time: head.sample_time,
            dates: Dates::new(map.time.date_order),
        })
    }

    /// The text in a column of the row; of a day and a time in two columns both.
    fn text(&self, column: usize) -> Result<String, LogError> {
        let text = |column: usize| text(&self.file, self.row, &self.cells[column]);
        let own = text(column)?;
        Ok(match self.dialect.pair {
            Some((day, time)) if time == column && !is_missing(own.trim()) => {
                format!("{} {}", text(day)?.trim(), own.trim())
            }
            _ => own.trim().to_owned(),
        })
    }
}

impl<R: Read> LogSource for CsvSource<R> {
    fn file(&self) -> &str {
        &self.file
    }

    fn columns(&self) -> &[HeaderColumn] {
        &self.dialect.columns
    }

    fn sample_time(&self) -> Option<f64> {
        self.sample_time
    }

    fn date_column(&self) -> Option<usize> {
        self.dialect.date_column
    }

    fn notes(&self) -> Vec<String> {
        self.dialect.notes.clone()
    }

    fn next_row(&mut self) -> Result<Option<u64>, LogError> {
        let before = self.csv.position().line();
        if !self.csv.read_byte_record(&mut self.cells).map_err(|e| csv_error(&self.file, &e))? {
            return Ok(None);
        }
        self.row = self.lines.row(before, self.csv.position().line());
        let (expected, found) = (self.dialect.columns.len(), self.cells.len());
        if found != expected {
            let (file, row) = (self.file.clone(), self.row);
            return Err(LogError::Cells { file, row, expected, found });
        }
        Ok(Some(self.row))
    }

    fn number(&self, column: usize) -> Result<f64, LogError> {
        let is_date = self.dialect.dates[column];
        // A plain number is by far the most frequent cell.
        if !is_date && !self.dialect.decimal_comma {
            let plain = std::str::from_utf8(&self.cells[column]).ok();
            let plain = plain.and_then(|text| text.trim().parse::<f64>().ok());
            if let Some(number) = plain.filter(|number| number.is_finite()) {
                return Ok(number);
            }
        }
        let found = self.text(column)?;
        if is_missing(&found) {
            return Ok(f64::NAN);
        }
        let name = || (self.file.clone(), self.dialect.columns[column].text.clone());
        if is_date {
            match self.dates.seconds(column, &found) {
                When::At(seconds) => return Ok(seconds),
                When::Unclear => {
                    let ((file, column), row) = (name(), self.row);
                    return Err(LogError::UnclearDate { file, column, row, found });
                }
                When::Never => {}
            }
        }
        number(&found, self.dialect.decimal_comma).ok_or_else(|| {
            let ((file, column), row) = (name(), self.row);
            LogError::Number { file, column, row, found }
        })
    }
}

fn csv_error(file: &str, error: &csv::Error) -> LogError {
    match error.kind() {
        csv::ErrorKind::Io(error) => cannot_read(file, error),
        // Byte records of any length are read, so no other kind can occur.
        _ => cannot_read(file, &io::ErrorKind::InvalidData.into()),
    }
}
