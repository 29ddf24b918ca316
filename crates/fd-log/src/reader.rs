//! Reading of logs, row by row or as a whole.

use std::{
    fs::File,
    io::{self, BufReader, Cursor, Read},
    path::Path,
};

use csv::ByteRecord;
use fd_model::{Channel, Record, TimeBaseError, TimeBaseReport, TimeSeries};

use crate::{
    columns::{Column, Time, resolve, rule_columns, time_source},
    error::LogError,
    head::{Head, LineCounter, cannot_read, utf8},
    header::{HeaderColumn, detect_delimiter},
    map::{LogMap, RowRule},
};

/// A log on an even time base, and what its own time base was like.
#[derive(Clone, Debug, PartialEq)]
pub struct Log {
    /// The signals.
    pub record: Record,
    /// The time base of the file.
    pub time_base: TimeBaseReport,
}

/// One row of a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogRow<'a> {
    /// Line of the file, from 1.
    pub row: u64,
    /// Time in seconds.
    pub time: f64,
    /// Inputs, NaN where they are missing.
    pub u: &'a [f64],
    /// Outputs, NaN where they are missing.
    pub y: &'a [f64],
}

/// Reads a log of any size row by row, in the memory of one row.
#[derive(Debug)]
pub struct LogReader<R> {
    file: String,
    csv: csv::Reader<io::Chain<Cursor<Vec<u8>>, BufReader<R>>>,
    cells: ByteRecord,
    width: usize,
    lines: LineCounter,
    decimal_comma: bool,
    time: Time,
    rules: Vec<(RowRule, Column)>,
    columns: Vec<Column>,
    rows_read: u64,
    inputs: Vec<Channel>,
    outputs: Vec<Channel>,
    values: Vec<f64>,
    sample_time: Option<f64>,
}

/// Reads a log and puts it on an even time base.
///
/// # Errors
///
/// Returns an error with the place in the file when the file cannot be read, columns are missing
/// or have the wrong unit, a cell is not a number, or time does not increase.
pub fn read_log(path: impl AsRef<Path>, map: &LogMap) -> Result<Log, LogError> {
    LogReader::open(path, map)?.read_all(map)
}

/// Reads a log from anywhere; `file` is the name for errors.
///
/// ```
/// use fd_log::{LogMap, read_log_from};
/// use fd_model::Channel;
///
/// let csv = "t,T_7 [degC],wf [kg/s]\n0,20,0.1\n0.5,,0.1\n1,22,0.2\n";
/// let map = LogMap::for_channels(&[Channel::new("wf", "kg/s")], &[Channel::new("T_7", "K")]);
/// let log = read_log_from("run3.csv", csv.as_bytes(), &map)?;
/// assert!((log.record.y(2)[0] - 295.15).abs() < 1e-12);
/// assert!(log.record.y(1)[0].is_nan());
/// # Ok::<(), fd_log::LogError>(())
/// ```
///
/// # Errors
///
/// As [`read_log`].
pub fn read_log_from(file: &str, from: impl Read, map: &LogMap) -> Result<Log, LogError> {
    LogReader::new(file, from, map)?.read_all(map)
}

impl LogReader<File> {
    /// Opens a file and reads its header.
    ///
    /// # Errors
    ///
    /// As [`LogReader::new`], and when the file cannot be opened.
    pub fn open(path: impl AsRef<Path>, map: &LogMap) -> Result<Self, LogError> {
        let path = path.as_ref();
        let file = path.display().to_string();
        let from = File::open(path).map_err(|error| cannot_read(&file, error.kind()))?;
        Self::new(&file, from, map)
    }
}

impl<R: Read> LogReader<R> {
    /// Reads the header; `file` is the name for errors.
    ///
    /// ```
    /// # use fd_log::{LogMap, LogReader};
    /// # use fd_model::Channel;
    /// let map = LogMap::for_channels(&[], &[Channel::new("y", "1")]);
    /// let mut reader = LogReader::new("run.csv", "t,y\n0,5\n1,6\n".as_bytes(), &map)?;
    /// let mut sum = 0.0;
    /// while let Some(row) = reader.next_row()? {
    ///     sum += row.y[0];
    /// }
    /// assert_eq!(sum, 11.0);
    /// # Ok::<(), fd_log::LogError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when the file is empty, columns are missing or ambiguous, or a unit does
    /// not fit.
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
        let header = cells
            .iter()
            .map(|cell| Ok(HeaderColumn::parse(utf8(file, row, cell)?)))
            .collect::<Result<Vec<_>, LogError>>()?;

        if map.outputs.is_empty() {
            return Err(LogError::NoOutputs { file: file.to_owned() });
        }
        let time = time_source(file, &header, map)?;
        let (mut columns, mut inputs, mut outputs) = (Vec::new(), Vec::new(), Vec::new());
        for (channels, maps) in [(&mut inputs, &map.inputs), (&mut outputs, &map.outputs)] {
            for map in maps {
                let (column, channel) = resolve(file, &header, map)?;
                columns.push(column);
                channels.push(channel);
            }
        }
        Ok(Self {
            file: file.to_owned(),
            csv,
            cells,
            width: header.len(),
            lines: LineCounter { before_header: head.lines_before, crlf },
            decimal_comma: map.decimal_comma,
            time,
            rules: rule_columns(file, &header, &map.rows)?,
            values: vec![f64::NAN; columns.len()],
            columns,
            rows_read: 0,
            inputs,
            outputs,
            sample_time: head.sample_time,
        })
    }

    /// Input channels.
    #[must_use]
    pub fn inputs(&self) -> &[Channel] {
        &self.inputs
    }

    /// Output channels.
    #[must_use]
    pub fn outputs(&self) -> &[Channel] {
        &self.outputs
    }

    /// The next row that belongs to the log, in the units of the channels, or nothing at the end.
    /// Times are as they are in the file, in any order.
    ///
    /// # Errors
    ///
    /// Returns an error when the file cannot be read, the row has the wrong number of cells, or a
    /// cell is not a number.
    pub fn next_row(&mut self) -> Result<Option<LogRow<'_>>, LogError> {
        let Some(row) = self.next_admitted()? else { return Ok(None) };
        let time = match &self.time {
            Time::Rows(ts) => self.rows_read as f64 * ts.seconds(),
            Time::Column(column) => {
                let (time, text) = self.number(row, column)?;
                if time.is_nan() {
                    return Err(self.not_a_number(row, column, text));
                }
                time
            }
        };
        self.rows_read += 1;
        for i in 0..self.columns.len() {
            self.values[i] = self.number(row, &self.columns[i])?.0;
        }
        let (u, y) = self.values.split_at(self.inputs.len());
        Ok(Some(LogRow { row, time, u, y }))
    }

    /// Reads cells up to a row that all rules admit, and returns its line.
    fn next_admitted(&mut self) -> Result<Option<u64>, LogError> {
        loop {
            let before = self.csv.position().line();
            if !self.csv.read_byte_record(&mut self.cells).map_err(|e| csv_error(&self.file, &e))? {
                return Ok(None);
            }
            let row = self.lines.row(before, self.csv.position().line());
            if self.cells.len() != self.width {
                let (expected, found) = (self.width, self.cells.len());
                return Err(LogError::Cells { file: self.file.clone(), row, expected, found });
            }
            let mut is_admitted = true;
            for (rule, column) in &self.rules {
                is_admitted &= rule.admits(self.number(row, column)?.0);
            }
            if is_admitted {
                return Ok(Some(row));
            }
        }
    }

    fn read_all(mut self, map: &LogMap) -> Result<Log, LogError> {
        let mut series = TimeSeries {
            inputs: self.inputs.clone(),
            outputs: self.outputs.clone(),
            ..TimeSeries::default()
        };
        let mut rows = Vec::new();
        while let Some(LogRow { row, time, u, y }) = self.next_row()? {
            rows.push(row);
            series.t.push(time);
            series.u.extend_from_slice(u);
            series.y.extend_from_slice(y);
        }
        if rows.is_empty() {
            let file = self.file;
            let rules = map.rows.clone();
            let is_empty = rules.is_empty();
            return Err(if is_empty {
                LogError::NoRows { file }
            } else {
                LogError::NoneSelected { file, rules }
            });
        }
        let mut policy = map.resample.clone();
        policy.sample_time = map.time.sample_time.or(policy.sample_time).or(self.sample_time);
        match series.resample(&policy) {
            Ok((record, time_base)) => Ok(Log { record, time_base }),
            Err(source) => Err(self.time_error(source, &rows)),
        }
    }

    /// Puts the row of the file into errors about single samples.
    fn time_error(&self, source: TimeBaseError, rows: &[u64]) -> LogError {
        let file = self.file.clone();
        match (source, &self.time) {
            (TimeBaseError::NotIncreasing { index, before, time }, Time::Column(column)) => {
                let (column, row) = (column.text.clone(), rows[index]);
                LogError::NotIncreasing { file, column, row, before, time }
            }
            (source, _) => LogError::TimeBase { file, source },
        }
    }

    /// A cell as a number in the unit of its channel, and its text.
    fn number(&self, row: u64, column: &Column) -> Result<(f64, &str), LogError> {
        let text = utf8(&self.file, row, &self.cells[column.index])?.trim();
        if is_missing(text) {
            return Ok((f64::NAN, text));
        }
        let parsed = if self.decimal_comma {
            text.replace(',', ".").parse::<f64>()
        } else {
            text.parse::<f64>()
        };
        match parsed {
            Ok(value) if value.is_finite() => Ok((column.conversion.apply(value), text)),
            _ => Err(self.not_a_number(row, column, text)),
        }
    }

    fn not_a_number(&self, row: u64, column: &Column, found: &str) -> LogError {
        let (file, column) = (self.file.clone(), column.text.clone());
        LogError::Number { file, column, row, found: found.to_owned() }
    }
}

/// Whether a cell says that there is no value.
fn is_missing(text: &str) -> bool {
    text.is_empty() || ["nan", "na", "n/a", "null"].iter().any(|m| text.eq_ignore_ascii_case(m))
}

fn csv_error(file: &str, error: &csv::Error) -> LogError {
    let kind = match error.kind() {
        csv::ErrorKind::Io(error) => error.kind(),
        // Byte records of any length are read, so no other kind can occur.
        _ => io::ErrorKind::InvalidData,
    };
    cannot_read(file, kind)
}
