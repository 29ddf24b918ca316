//! Reading of logs, row by row or as a whole.

use fd_model::{Channel, Record, TimeBaseError, TimeBaseReport, TimeSeries};

use crate::{
    column::{Column, Moment},
    columns::{Time, resolve, rule_columns, time_source},
    error::LogError,
    limit::Budget,
    map::{LogMap, RowRule},
    source::LogSource,
};

/// A log on an even time base, and what its own time base was like.
#[derive(Clone, Debug, PartialEq)]
pub struct Log {
    /// The signals.
    pub record: Record,
    /// The time base of the file.
    pub time_base: TimeBaseReport,
    /// The column that was taken for time; nothing where rows are counted.
    pub time_column: Option<String>,
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

/// Reads a log of any size and format row by row, in the memory of one row.
#[derive(Debug)]
pub struct LogReader<S> {
    source: S,
    time: Time,
    rules: Vec<(RowRule, Column)>,
    columns: Vec<Column>,
    /// Rows of the file, and those of them that belong to the log.
    rows_seen: u64,
    rows_read: u64,
    inputs: Vec<Channel>,
    outputs: Vec<Channel>,
    values: Vec<f64>,
    map: LogMap,
}

impl<S: LogSource> LogReader<S> {
    /// Finds the columns of a map in a source.
    ///
    /// ```
    /// # use fd_log::{CsvSource, LogMap, LogReader};
    /// # use fd_model::Channel;
    /// let map = LogMap::for_channels(&[], &[Channel::new("y", "1")]);
    /// let csv = CsvSource::new("run.csv", "t,y\n0,5\n1,6\n".as_bytes(), &map)?;
    /// let mut reader = LogReader::new(csv, &map)?;
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
    /// Returns an error when the map has no outputs, columns are missing or ambiguous, or a unit does
    /// not fit.
    pub fn new(source: S, map: &LogMap) -> Result<Self, LogError> {
        let (file, header, all) = (source.file(), source.columns(), map);
        if map.outputs.is_empty() {
            return Err(LogError::NoOutputs { file: file.to_owned() });
        }
        let time = time_source(file, header, source.date_column(), map)?;
        let (mut columns, mut inputs, mut outputs) = (Vec::new(), Vec::new(), Vec::new());
        for (channels, maps) in [(&mut inputs, &map.inputs), (&mut outputs, &map.outputs)] {
            for map in maps {
                let (column, channel) = resolve(file, header, all, map)?;
                columns.push(column);
                channels.push(channel);
            }
        }
        Ok(Self {
            rules: rule_columns(file, header, map)?,
            values: vec![f64::NAN; columns.len()],
            time,
            columns,
            rows_seen: 0,
            rows_read: 0,
            inputs,
            outputs,
            map: map.clone(),
            source,
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
        let needs_time = self.rules.iter().any(|(_, column)| column.needs_time());
        let Some(row) = self.next_admitted(needs_time)? else { return Ok(None) };
        let Self { source, time, columns, values, rows_seen, rows_read, .. } = &mut *self;
        let time = match time {
            // Where a rule names the time, rows that are left out take time, too.
            Time::Rows(ts) => {
                let rows = if needs_time { *rows_seen - 1 } else { *rows_read };
                rows as f64 * ts.seconds()
            }
            Time::Column(column) => {
                let time = column.number(source, Moment { row, time: f64::NAN })?;
                if time.is_nan() {
                    let (file, column) = (source.file().to_owned(), column.text.clone());
                    return Err(LogError::NoTimeInRow { file, column, row });
                }
                time
            }
        };
        for (value, column) in values.iter_mut().zip(columns) {
            *value = column.number(source, Moment { row, time })?;
        }
        *rows_read += 1;
        let (u, y) = self.values.split_at(self.inputs.len());
        Ok(Some(LogRow { row, time, u, y }))
    }

    /// Goes on to a row that all rules admit, and returns its number.
    fn next_admitted(&mut self, needs_time: bool) -> Result<Option<u64>, LogError> {
        while let Some(row) = self.source.next_row()? {
            let mut is_admitted = true;
            let mut now = Moment { row, time: f64::NAN };
            if needs_time {
                now.time = match &mut self.time {
                    Time::Column(column) => column.number(&self.source, now)?,
                    Time::Rows(ts) => self.rows_seen as f64 * ts.seconds(),
                };
            }
            self.rows_seen += 1;
            for (rule, column) in &mut self.rules {
                // What a row is that is out already is not asked.
                is_admitted = is_admitted && rule.admits(column.number(&self.source, now)?);
            }
            if is_admitted {
                return Ok(Some(row));
            }
        }
        Ok(None)
    }

    /// The whole log on an even time base.
    ///
    /// # Errors
    ///
    /// As [`read_log`](crate::read_log).
    pub fn read_all(mut self) -> Result<Log, LogError> {
        let mut series = TimeSeries {
            inputs: self.inputs.clone(),
            outputs: self.outputs.clone(),
            ..TimeSeries::default()
        };
        let mut rows = Vec::new();
        let mut left = Budget::new(self.source.file());
        let (what, width) = ("rows of the log", 2 + self.columns.len());
        while let Some(LogRow { row, time, u, y }) = self.next_row()? {
            left.take_rows(what, rows.len(), 8 * width)?;
            rows.push(row);
            series.t.push(time);
            series.u.extend_from_slice(u);
            series.y.extend_from_slice(y);
        }
        if rows.is_empty() {
            let file = self.source.file().to_owned();
            let rules: Vec<RowRule> = self.map.rules(&file).cloned().collect();
            return Err(if rules.is_empty() {
                LogError::NoRows { file }
            } else {
                LogError::NoneSelected { file, rules }
            });
        }
        let mut policy = self.map.resample.clone();
        let stated = self.map.time.sample_time.or(policy.sample_time);
        policy.sample_time = stated.or(self.source.sample_time());
        match series.resample(&policy) {
            Ok((record, time_base)) => {
                Ok(Log { record, time_base, time_column: self.time_column() })
            }
            Err(source) => Err(self.time_error(source, &rows)),
        }
    }

    /// Puts the row of the file into errors about single samples.
    fn time_error(&self, source: TimeBaseError, rows: &[u64]) -> LogError {
        let file = self.source.file().to_owned();
        match (source, &self.time) {
            (TimeBaseError::NotIncreasing { index, before, time }, Time::Column(column)) => {
                let (column, row) = (column.text.clone(), rows[index]);
                LogError::NotIncreasing { file, column, row, before, time }
            }
            (source, _) => {
                LogError::TimeBase { file, column: self.time_column(), source: Box::new(source) }
            }
        }
    }

    fn time_column(&self) -> Option<String> {
        match &self.time {
            Time::Column(column) => Some(column.text.clone()),
            Time::Rows(_) => None,
        }
    }
}
