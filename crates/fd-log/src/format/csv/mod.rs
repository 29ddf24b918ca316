//! Text with one row per line: columns between commas, semicolons or tabs, a header with names and units.

mod head;

use std::io::{self, BufReader, Cursor, Read};

use csv::ByteRecord;

use self::head::{Head, LineCounter, detect_delimiter, utf8};
use crate::{
    date::Dates,
    error::LogError,
    header::HeaderColumn,
    map::LogMap,
    source::{LogSource, cannot_read},
};

/// A CSV file, in the memory of one row.
#[derive(Debug)]
pub struct CsvSource<R> {
    file: String,
    csv: csv::Reader<io::Chain<Cursor<Vec<u8>>, BufReader<R>>>,
    cells: ByteRecord,
    row: u64,
    lines: LineCounter,
    decimal_comma: bool,
    columns: Vec<HeaderColumn>,
    sample_time: Option<f64>,
    dates: Dates,
}

impl<R: Read> CsvSource<R> {
    /// Reads the header; `file` is the name for errors. Of the map, only separators matter here.
    ///
    /// ```
    /// use fd_log::{CsvSource, LogMap, LogSource};
    ///
    /// let mut csv = CsvSource::new("run.csv", "t;y [K]\n0;5,5\n".as_bytes(), &LogMap {
    ///     decimal_comma: true,
    ///     ..LogMap::default()
    /// })?;
    /// assert_eq!(csv.columns()[1].unit.as_deref(), Some("K"));
    /// assert_eq!(csv.next_row()?, Some(2));
    /// assert_eq!(csv.number(1)?, 5.5);
    /// # Ok::<(), fd_log::LogError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when the file is empty, is no text, or was written in an unknown version.
    pub fn new(file: &str, from: R, map: &LogMap) -> Result<Self, LogError> {
        let (head, rest) = Head::read(file, from)?;
        let delimiter = match map.delimiter {
            Some(found) if found.is_ascii() => found as u8,
            Some(found) => return Err(LogError::Delimiter { file: file.to_owned(), found }),
            None if head.written_here => b',',
            None => detect_delimiter(&head.header),
        };
        let crlf = head.header.ends_with(b"\r\n");
        let mut csv = csv::ReaderBuilder::new()
            .delimiter(delimiter)
            .flexible(true)
            .has_headers(false)
            .from_reader(Cursor::new(head.header).chain(rest));
        let mut cells = ByteRecord::new();
        csv.read_byte_record(&mut cells).map_err(|error| csv_error(file, &error))?;
        let row = head.lines_before + 1;
        let columns = cells
            .iter()
            .map(|cell| Ok(HeaderColumn::parse(utf8(file, row, cell)?)))
            .collect::<Result<Vec<_>, LogError>>()?;
        Ok(Self {
            file: file.to_owned(),
            csv,
            cells,
            row,
            lines: LineCounter { before_header: head.lines_before, crlf },
            decimal_comma: map.decimal_comma,
            columns,
            sample_time: head.sample_time,
            dates: Dates::default(),
        })
    }
}

impl<R: Read> LogSource for CsvSource<R> {
    fn file(&self) -> &str {
        &self.file
    }

    fn columns(&self) -> &[HeaderColumn] {
        &self.columns
    }

    fn sample_time(&self) -> Option<f64> {
        self.sample_time
    }

    fn next_row(&mut self) -> Result<Option<u64>, LogError> {
        let before = self.csv.position().line();
        if !self.csv.read_byte_record(&mut self.cells).map_err(|e| csv_error(&self.file, &e))? {
            return Ok(None);
        }
        self.row = self.lines.row(before, self.csv.position().line());
        let (expected, found) = (self.columns.len(), self.cells.len());
        if found != expected {
            let (file, row) = (self.file.clone(), self.row);
            return Err(LogError::Cells { file, row, expected, found });
        }
        Ok(Some(self.row))
    }

    fn number(&self, column: usize) -> Result<f64, LogError> {
        let text = utf8(&self.file, self.row, &self.cells[column])?.trim();
        if is_missing(text) {
            return Ok(f64::NAN);
        }
        let parsed = if self.decimal_comma {
            text.replace(',', ".").parse::<f64>()
        } else {
            text.parse::<f64>()
        };
        let number = parsed.ok().filter(|value| value.is_finite());
        number.or_else(|| self.dates.seconds(text)).ok_or_else(|| LogError::Number {
            file: self.file.clone(),
            column: self.columns[column].text.clone(),
            row: self.row,
            found: text.to_owned(),
        })
    }
}

/// Whether a cell says that there is no value.
fn is_missing(text: &str) -> bool {
    text.is_empty() || ["nan", "na", "n/a", "null"].iter().any(|m| text.eq_ignore_ascii_case(m))
}

fn csv_error(file: &str, error: &csv::Error) -> LogError {
    match error.kind() {
        csv::ErrorKind::Io(error) => cannot_read(file, error),
        // Byte records of any length are read, so no other kind can occur.
        _ => cannot_read(file, &io::ErrorKind::InvalidData.into()),
    }
}
