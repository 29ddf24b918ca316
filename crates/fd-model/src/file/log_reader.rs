//! Reading of logs, row by row or as a whole.

use std::{
    fs::File,
    io::{self, BufRead, BufReader, Cursor, Read},
    path::Path,
};

use csv::ByteRecord;

use crate::{
    channel::Channel,
    domain::SampleTime,
    file::{
        log_error::LogError,
        log_header::{HeaderColumn, detect_delimiter, find, texts},
        log_map::{ColumnMap, LogMap},
        model_error::FileAction,
    },
    record::Record,
    resample::{TimeBaseError, TimeBaseReport, TimeSeries},
    unit::Conversion,
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
    columns: Vec<Column>,
    inputs: Vec<Channel>,
    outputs: Vec<Channel>,
    values: Vec<f64>,
    sample_time: Option<f64>,
}

/// A column that is read.
#[derive(Clone, Debug)]
struct Column {
    index: usize,
    text: String,
    conversion: Conversion,
}

#[derive(Clone, Debug)]
enum Time {
    Column(Column),
    Rows { ts: f64, next: u64 },
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
/// use fd_model::{Channel, file::{LogMap, read_log_from}};
///
/// let csv = "t,T_7 [degC],wf [kg/s]\n0,20,0.1\n0.5,,0.1\n1,22,0.2\n";
/// let map = LogMap::for_channels(&[Channel::new("wf", "kg/s")], &[Channel::new("T_7", "K")]);
/// let log = read_log_from("run3.csv", csv.as_bytes(), &map)?;
/// assert!((log.record.y(2)[0] - 295.15).abs() < 1e-12);
/// assert!(log.record.y(1)[0].is_nan());
/// # Ok::<(), fd_model::file::LogError>(())
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
    /// # use fd_model::{Channel, file::{LogMap, LogReader}};
    /// let map = LogMap::for_channels(&[], &[Channel::new("y", "1")]);
    /// let mut reader = LogReader::new("run.csv", "t,y\n0,5\n1,6\n".as_bytes(), &map)?;
    /// let mut sum = 0.0;
    /// while let Some(row) = reader.next_row()? {
    ///     sum += row.y[0];
    /// }
    /// assert_eq!(sum, 11.0);
    /// # Ok::<(), fd_model::file::LogError>(())
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
            values: vec![f64::NAN; columns.len()],
            columns,
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

    /// The next row, in the units of the channels, or nothing at the end. Times are as they are
    /// in the file, in any order.
    ///
    /// # Errors
    ///
    /// Returns an error when the file cannot be read, the row has the wrong number of cells, or a
    /// cell is not a number.
    pub fn next_row(&mut self) -> Result<Option<LogRow<'_>>, LogError> {
        let before = self.csv.position().line();
        if !self.csv.read_byte_record(&mut self.cells).map_err(|e| csv_error(&self.file, &e))? {
            return Ok(None);
        }
        let row = self.lines.row(before, self.csv.position().line());
        if self.cells.len() != self.width {
            let (expected, found) = (self.width, self.cells.len());
            return Err(LogError::Cells { file: self.file.clone(), row, expected, found });
        }
        let time = match &mut self.time {
            Time::Rows { ts, next } => {
                let time = *next as f64 * *ts;
                *next += 1;
                time
            }
            Time::Column(column) => {
                let column = column.clone();
                let (time, text) = self.number(row, &column)?;
                if time.is_nan() {
                    return Err(self.not_a_number(row, &column, text));
                }
                time
            }
        };
        for i in 0..self.columns.len() {
            self.values[i] = self.number(row, &self.columns[i])?.0;
        }
        let (u, y) = self.values.split_at(self.inputs.len());
        Ok(Some(LogRow { row, time, u, y }))
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
            return Err(LogError::NoRows { file: self.file });
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

fn time_source(file: &str, header: &[HeaderColumn], map: &LogMap) -> Result<Time, LogError> {
    let index = match (&map.time.column, map.time.sample_time) {
        (Some(column), _) => find(file, header, column)?,
        (None, Some(ts)) => {
            let ts = SampleTime::new(ts).map_err(|source| LogError::TimeBase {
                file: file.to_owned(),
                source: source.into(),
            })?;
            return Ok(Time::Rows { ts: ts.seconds(), next: 0 });
        }
        (None, None) => header
            .iter()
            .position(|c| ["time", "t", "time_s"].iter().any(|t| c.name.eq_ignore_ascii_case(t)))
            .ok_or_else(|| LogError::NoTime { file: file.to_owned(), known: texts(header) })?,
    };
    let seconds = ColumnMap {
        name: header[index].text.clone(),
        unit: Some("s".to_owned()),
        column: Some(header[index].text.clone()),
        column_unit: map.time.unit.clone(),
    };
    Ok(Time::Column(resolve(file, header, &seconds)?.0))
}

/// Finds a column and settles its unit.
fn resolve(
    file: &str,
    header: &[HeaderColumn],
    map: &ColumnMap,
) -> Result<(Column, Channel), LogError> {
    let index = find(file, header, map.column.as_ref().unwrap_or(&map.name))?;
    let HeaderColumn { text, unit: header_unit, .. } = &header[index];
    let column_unit = match (header_unit, &map.column_unit) {
        (Some(header), Some(map))
            if Conversion::between(header, map) != Ok(Conversion::IDENTITY) =>
        {
            let (file, column) = (file.to_owned(), text.clone());
            let (header, map) = (header.clone(), map.clone());
            return Err(LogError::UnitConflict { file, column, header, map });
        }
        (Some(unit), _) | (None, Some(unit)) => Some(unit),
        (None, None) => map.unit.as_ref(),
    };
    let column_unit = column_unit.map_or("1", String::as_str);
    let unit = map.unit.as_deref().unwrap_or(column_unit);
    let conversion = Conversion::between(column_unit, unit).map_err(|source| LogError::Unit {
        file: file.to_owned(),
        column: text.clone(),
        source,
    })?;
    Ok((Column { index, text: text.clone(), conversion }, Channel::new(map.name.clone(), unit)))
}

/// The lines of a file up to and including the header.
struct Head {
    header: Vec<u8>,
    lines_before: u64,
    /// Whether the file begins with the version line of the format.
    written_here: bool,
    sample_time: Option<f64>,
}

impl Head {
    fn read<R: Read>(file: &str, from: R) -> Result<(Self, BufReader<R>), LogError> {
        const UTF8_MARK: &[u8] = b"\xEF\xBB\xBF";
        let mut from = BufReader::new(from);
        let mut head =
            Self { header: Vec::new(), lines_before: 0, written_here: false, sample_time: None };
        loop {
            let mut line = Vec::new();
            from.read_until(b'\n', &mut line).map_err(|error| cannot_read(file, error.kind()))?;
            if head.lines_before == 0 {
                if line.starts_with(b"\xFF\xFE") || line.starts_with(b"\xFE\xFF") {
                    let found = "a UTF-16 byte order mark".to_owned();
                    return Err(LogError::NotUtf8 { file: file.to_owned(), row: 1, found });
                }
                line = line.strip_prefix(UTF8_MARK).map_or(line.clone(), <[u8]>::to_vec);
            }
            if line.is_empty() {
                return Err(LogError::Empty { file: file.to_owned() });
            }
            if line.starts_with(b"#") {
                head.comment(file, &line)?;
            } else if !line.trim_ascii().is_empty() {
                head.header = line;
                return Ok((head, from));
            }
            head.lines_before += 1;
        }
    }

    /// Reads `# fdiag-log version=1 sample_time=0.1`; any other comment is skipped.
    fn comment(&mut self, file: &str, line: &[u8]) -> Result<(), LogError> {
        let text = String::from_utf8_lossy(line);
        let mut words = text.trim_start_matches('#').split_whitespace();
        if self.lines_before > 0 || words.next() != Some("fdiag-log") {
            return Ok(());
        }
        self.written_here = true;
        for (key, value) in words.filter_map(|word| word.split_once('=')) {
            match key {
                "version" if value != "1" => {
                    let (file, found) = (file.to_owned(), value.to_owned());
                    return Err(LogError::Version { file, found });
                }
                "sample_time" => self.sample_time = value.parse().ok(),
                _ => {}
            }
        }
        Ok(())
    }
}

/// From the line counts of the CSV reader to lines of the file.
#[derive(Clone, Copy, Debug)]
struct LineCounter {
    before_header: u64,
    crlf: bool,
}

impl LineCounter {
    /// Line of the record between whose start and end the reader counted `before` and `after`.
    ///
    /// The reader skips blank lines at the start of a record, and takes the second byte of a
    /// CR LF for one of those.
    fn row(self, before: u64, after: u64) -> u64 {
        let line = if self.crlf { after.max(before + 1) } else { before.max(after - 1) };
        self.before_header + line
    }
}

fn utf8<'a>(file: &str, row: u64, cell: &'a [u8]) -> Result<&'a str, LogError> {
    std::str::from_utf8(cell).map_err(|_| LogError::NotUtf8 {
        file: file.to_owned(),
        row,
        found: format!("`{}`", cell.escape_ascii()),
    })
}

fn csv_error(file: &str, error: &csv::Error) -> LogError {
    let kind = match error.kind() {
        csv::ErrorKind::Io(error) => error.kind(),
        // Byte records of any length are read, so no other kind can occur.
        _ => io::ErrorKind::InvalidData,
    };
    cannot_read(file, kind)
}

fn cannot_read(file: &str, kind: io::ErrorKind) -> LogError {
    LogError::Io { file: file.to_owned(), action: FileAction::Read, kind }
}
