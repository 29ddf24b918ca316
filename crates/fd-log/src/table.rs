//! A log that is in memory, and no file.

use std::{borrow::Borrow, sync::Arc};

use crate::{
    error::LogError,
    header::HeaderColumn,
    map::LogMap,
    reader::{Log, LogReader},
    source::LogSource,
};

/// A log in memory: named columns of numbers, NaN where there is no value.
///
/// ```
/// use fd_log::{LogMap, LogTable};
/// use fd_model::Channel;
///
/// let columns = [("t", vec![0.0, 0.5, 1.0]), ("T_7 [degC]", vec![20.0, f64::NAN, 22.0])];
/// let table = LogTable::new("monday", columns)?;
/// let log = table.read(&LogMap::for_channels(&[], &[Channel::new("T_7", "K")]))?;
/// assert!((log.record.y(2)[0] - 295.15).abs() < 1e-12);
/// assert!(log.record.y(1)[0].is_nan());
/// # Ok::<(), fd_log::LogError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct LogTable {
    name: String,
    columns: Vec<HeaderColumn>,
    /// One list per column, all of the same length.
    values: Vec<Arc<Vec<f64>>>,
    /// Time between rows in seconds, if whoever made the table states it.
    sample_time: Option<f64>,
}

impl LogTable {
    /// A table of columns; a unit may stand behind a name as in the header of a file (`T_7 [K]`). `name` is what
    /// the log is called in messages and reports.
    ///
    /// # Errors
    ///
    /// Returns an error when there is no column, or columns differ in length.
    pub fn new<C: AsRef<str>>(
        name: impl Into<String>,
        columns: impl IntoIterator<Item = (C, Vec<f64>)>,
    ) -> Result<Self, LogError> {
        let columns = columns.into_iter();
        let columns =
            columns.map(|(header, values)| (HeaderColumn::parse(header.as_ref()), values));
        Self::of_columns(name.into(), columns.collect(), None)
    }

    /// A table of columns whose names and units are known apart.
    pub(crate) fn of_columns(
        name: String,
        columns: Vec<(HeaderColumn, Vec<f64>)>,
        sample_time: Option<f64>,
    ) -> Result<Self, LogError> {
        let mut table = Self { name, columns: Vec::new(), values: Vec::new(), sample_time };
        for (header, values) in columns {
            let (expected, found) = (table.rows(), values.len());
            if !table.columns.is_empty() && found != expected {
                let (file, column) = (table.name, header.text);
                return Err(LogError::Ragged { file, column, expected, found });
            }
            table.columns.push(header);
            // Not copied: a column may be a good part of the memory.
            table.values.push(Arc::new(values));
        }
        if table.columns.is_empty() {
            return Err(LogError::Empty { file: table.name });
        }
        Ok(table)
    }

    /// What the log is called.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.values.first().map_or(0, |values| values.len())
    }

    /// The log on an even time base, with the channels of a map. Rows are counted from 1.
    ///
    /// # Errors
    ///
    /// As [`read_log`](crate::read_log), but that there is no file to be read.
    pub fn read(&self, map: &LogMap) -> Result<Log, LogError> {
        LogReader::new(Rows { table: self, row: 0 }, map)?.read_all()
    }

    /// The table as a source of rows.
    pub(crate) fn into_source(self) -> Box<dyn LogSource> {
        Box::new(Rows { table: self, row: 0 })
    }
}

/// A table, row by row.
struct Rows<T> {
    table: T,
    /// Rows that were begun.
    row: usize,
}

impl<T: Borrow<LogTable>> LogSource for Rows<T> {
    fn file(&self) -> &str {
        &self.table.borrow().name
    }

    fn columns(&self) -> &[HeaderColumn] {
        &self.table.borrow().columns
    }

    fn sample_time(&self) -> Option<f64> {
        self.table.borrow().sample_time
    }

    fn next_row(&mut self) -> Result<Option<u64>, LogError> {
        self.row += 1;
        Ok((self.row <= self.table.borrow().rows()).then_some(self.row as u64))
    }

    fn number(&self, column: usize) -> Result<f64, LogError> {
        let table = self.table.borrow();
        let number = table.values[column][self.row - 1];
        if number.is_infinite() {
            return Err(LogError::Number {
                file: table.name.clone(),
                column: table.columns[column].text.clone(),
                row: self.row as u64,
                found: number.to_string(),
            });
        }
        Ok(number)
    }
}

#[cfg(test)]
mod tests {
    use fd_model::Channel;

    use super::*;

    #[test]
    fn a_table_is_read_as_the_file_of_it() {
        let csv = "t,u,y [mm]\n0,1,2.5\n0.1,2,\n0.2,0.1,7\n";
        let map = LogMap::for_channels(&[Channel::new("u", "1")], &[Channel::new("y", "m")]);
        let file = crate::read_log_from("run", csv.as_bytes(), &map).unwrap();
        let columns = [
            ("t", vec![0.0, 0.1, 0.2]),
            ("u", vec![1.0, 2.0, 0.1]),
            ("y [mm]", vec![2.5, f64::NAN, 7.0]),
        ];
        let table = LogTable::new("run", columns).unwrap().read(&map).unwrap();
        assert_eq!(file.time_base, table.time_base);
        for k in 0..3 {
            assert_eq!(file.record.u(k), table.record.u(k));
            assert_eq!(file.record.y(k)[0].to_bits(), table.record.y(k)[0].to_bits());
        }
    }

    #[test]
    fn what_is_wrong_is_said() {
        let map = LogMap::for_channels(&[], &[Channel::new("speed", "1")]);
        let said = |columns: &[(&str, Vec<f64>)]| {
            let table = LogTable::new("monday", columns.iter().cloned());
            table.and_then(|table| table.read(&map)).unwrap_err().to_string()
        };
        let time = ("t", vec![0.0, 1.0]);
        assert_eq!(
            said(&[time.clone(), ("speed", vec![1.0])]),
            "monday: column `speed`: expected 2 values, as in the others, found 1"
        );
        assert!(said(&[time.clone(), ("sped", vec![1.0, 2.0])]).contains("did you mean `sped`?"));
        assert!(
            said(&[time, ("speed", vec![1.0, f64::INFINITY])])
                .contains("row 2: expected a finite number, found `inf`")
        );
        assert!(said(&[]).contains("empty"));
    }
}
