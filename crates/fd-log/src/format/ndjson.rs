//! One JSON object per line: keys are columns, values are numbers; `null` and a missing key are no value.
//!
//! The keys of the first object are the columns, in alphabetical order; a unit may stand behind a name as in the
//! header of a CSV file (`"T_7 [K]"`). Booleans count as 0 and 1, so that a switch can be an input. A key that the
//! first object does not have is an error: what a log holds is said at its beginning, or a typing error would
//! look like missing samples.

use std::io::{BufRead, BufReader, Read};

use serde_json::{Map, Value};

use super::bounded::check_columns;
use crate::{
    date::{self, Dates, When},
    error::LogError,
    header::HeaderColumn,
    map::LogMap,
    source::{LogSource, cannot_read},
};

/// An NDJSON file, in the memory of one line.
#[derive(Debug)]
pub struct NdjsonSource<R> {
    file: String,
    from: BufReader<R>,
    columns: Vec<HeaderColumn>,
    /// The first object, until it is read as a row.
    first: Option<Map<String, Value>>,
    row: u64,
    cells: Map<String, Value>,
    dates: Dates,
    date_column: Option<usize>,
}

impl<R: Read> NdjsonSource<R> {
    /// Reads the first object; `file` is the name for errors. Of the map, only the order of dates matters here.
    ///
    /// ```
    /// use fd_log::{LogMap, LogSource, NdjsonSource};
    ///
    /// let text = "{\"t\": 0, \"y [K]\": 20.5}\n{\"t\": 1, \"y [K]\": null}\n";
    /// let mut log = NdjsonSource::new("run.ndjson", text.as_bytes(), &LogMap::default())?;
    /// assert_eq!(log.columns()[1].name, "y");
    /// assert_eq!(log.next_row()?, Some(1));
    /// assert_eq!(log.number(1)?, 20.5);
    /// log.next_row()?;
    /// assert!(log.number(1)?.is_nan());
    /// # Ok::<(), fd_log::LogError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when the file cannot be read, is empty, or does not begin with an object.
    pub fn new(file: &str, from: R, map: &LogMap) -> Result<Self, LogError> {
        let mut source = Self {
            file: file.to_owned(),
            from: BufReader::new(from),
            columns: Vec::new(),
            first: None,
            row: 0,
            cells: Map::new(),
            dates: Dates::new(map.time.date_order),
            date_column: None,
        };
        let first = source.object()?.filter(|object| !object.is_empty());
        let first = first.ok_or_else(|| LogError::Empty { file: file.to_owned() })?;
        check_columns(file, first.len())?;
        source.columns = first.keys().map(|key| HeaderColumn::parse(key)).collect();
        let is_date = |cell: &Value| cell.as_str().is_some_and(|text| date::kind(text).is_some());
        let dates: Vec<usize> =
            (0..).zip(first.values()).filter(|(_, v)| is_date(v)).map(|(i, _)| i).collect();
        for date in &dates {
            source.columns[*date].unit = Some("s".to_owned());
        }
        source.date_column = if let [only] = dates[..] { Some(only) } else { None };
        source.first = Some(first);
        Ok(source)
    }

    /// The object in the next line that is not blank.
    fn object(&mut self) -> Result<Option<Map<String, Value>>, LogError> {
        let mut line = Vec::new();
        loop {
            line.clear();
            let read = self.from.read_until(b'\n', &mut line);
            if read.map_err(|error| cannot_read(&self.file, &error))? == 0 {
                return Ok(None);
            }
            self.row += 1;
            if !line.trim_ascii().is_empty() {
                break;
            }
        }
        serde_json::from_slice(&line).map(Some).map_err(|error| {
            let (file, row) = (self.file.clone(), self.row);
            // The line is known better from here than from the text of one line.
            let found = error.to_string();
            let found = found.split(" at line ").next().unwrap_or_default().to_owned();
            LogError::NotAnObject { file, row, found }
        })
    }
}

impl<R: Read> LogSource for NdjsonSource<R> {
    fn file(&self) -> &str {
        &self.file
    }

    fn columns(&self) -> &[HeaderColumn] {
        &self.columns
    }

    fn date_column(&self) -> Option<usize> {
        self.date_column
    }

    fn next_row(&mut self) -> Result<Option<u64>, LogError> {
        self.cells = match self.first.take() {
            Some(first) => first,
            None => match self.object()? {
                Some(object) => object,
                None => return Ok(None),
            },
        };
        let is_new = |key: &&String| !self.columns.iter().any(|column| column.text == key.trim());
        if let Some(key) = self.cells.keys().find(is_new) {
            let (file, row, key) = (self.file.clone(), self.row, key.clone());
            return Err(LogError::NewKey { file, row, key });
        }
        Ok(Some(self.row))
    }

    fn number(&self, column: usize) -> Result<f64, LogError> {
        let wanted = &self.columns[column].text;
        let cell = self.cells.iter().find(|(key, _)| key.trim() == wanted).map(|(_, value)| value);
        let number = match cell {
            None | Some(Value::Null) => return Ok(f64::NAN),
            Some(Value::Bool(is_on)) => Some(f64::from(u8::from(*is_on))),
            Some(Value::String(text)) => match self.dates.seconds(column, text) {
                When::At(seconds) => Some(seconds),
                When::Unclear => {
                    let (file, column) = (self.file.clone(), wanted.clone());
                    let (row, found) = (self.row, text.clone());
                    return Err(LogError::UnclearDate { file, column, row, found });
                }
                When::Never => None,
            },
            Some(value) => value.as_f64().filter(|number| number.is_finite()),
        };
        number.ok_or_else(|| LogError::Number {
            file: self.file.clone(),
            column: wanted.clone(),
            row: self.row,
            found: cell.map(Value::to_string).unwrap_or_default(),
        })
    }
}

#[cfg(test)]
mod tests {
    use fd_model::Channel;

    use super::*;
    use crate::{LogMap, LogReader, read_log};

    fn read(text: &str) -> Result<crate::Log, LogError> {
        let map = LogMap::for_channels(&[Channel::new("on", "1")], &[Channel::new("T_7", "K")]);
        LogReader::new(NdjsonSource::new("run.ndjson", text.as_bytes(), &map)?, &map)?.read_all()
    }

    #[test]
    fn objects_are_rows_and_units_are_converted() {
        let log = read(
            "{\"t\": 0, \"T_7 [degC]\": 20, \"on\": true}\n\n{\"t\": 0.5, \"on\": false}\n{\"on\": 0, \"t\": 1, \"T_7 [degC]\": 22}",
        )
        .unwrap();
        assert_eq!(log.record.u(0), [1.0]);
        assert!((log.record.y(2)[0] - 295.15).abs() < 1e-12);
        assert!(log.record.y(1)[0].is_nan());
    }

    #[test]
    fn errors_say_where() {
        let error = |text: &str| read(text).unwrap_err();
        assert_eq!(error(""), LogError::Empty { file: "run.ndjson".to_owned() });
        assert!(matches!(error("{\"t\": 0}\n[1]\n"), LogError::MissingColumn { .. }));
        let good = "{\"t\": 0, \"T_7\": 1, \"on\": 0}\n";
        let second = |line: &str| error(&format!("{good}\n{line}")).to_string();
        assert!(second("[1]").starts_with("run.ndjson, row 3: expected a JSON object of numbers"));
        assert!(second("{\"t\": 1, \"T_8\": 2}").contains("row 3: expected the keys of the first"));
        assert!(
            second("{\"t\": 1, \"T_7\": \"2\"}")
                .contains("row 3: expected a finite number, found `\"2\"`")
        );
        assert!(second("{\"T_7\": 2}").contains("row 3: expected a time, found no value"));
        assert!(second("{\"t\": 1, \"T_7\":").contains("row 3: expected a JSON object"));
    }

    #[test]
    fn the_ending_of_the_name_says_the_format() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.JSONL");
        std::fs::write(
            &path,
            "{\"t\": 0, \"T_7\": 1, \"on\": 0}\n{\"t\": 1, \"T_7\": 2, \"on\": 1}\n",
        )
        .unwrap();
        let map = LogMap::for_channels(&[Channel::new("on", "1")], &[Channel::new("T_7", "1")]);
        assert_eq!(read_log(&path, &map).unwrap().record.y(1), [2.0]);
    }
}
