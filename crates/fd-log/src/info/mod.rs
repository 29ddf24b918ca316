//! What is in a log file, before anybody says what it is for.

mod clock;
mod column;

use std::path::Path;

use serde::Serialize;

use self::column::Tally;
pub use self::{clock::ClockInfo, column::ColumnInfo};
use crate::{
    columns::time_column,
    error::LogError,
    format::{Opened, read},
    header::HeaderColumn,
    limit::Budget,
    map::LogMap,
    recording::Topic,
    source::LogSource,
};

/// What a log file holds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LogInfo {
    /// Name of the file.
    pub file: String,
    /// Its format, as people say it.
    pub format: String,
    /// Time between rows in seconds, if the file states it.
    pub sample_time: Option<f64>,
    /// What was taken at the same instants; more than one where a file has several clocks.
    pub tables: Vec<TableInfo>,
    /// What is in the file and is no column of numbers, and why.
    pub left: Vec<(String, String)>,
    /// How the file was read where that is not said by the file itself.
    pub notes: Vec<String>,
    /// What should be looked at before the log is trusted, about the file as a whole.
    pub doubts: Vec<String>,
}

/// Columns with one clock.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TableInfo {
    /// What it is called; empty where the file has only one.
    pub name: String,
    /// Number of rows.
    pub rows: usize,
    /// Its time base; nothing where no column is time.
    pub clock: Option<ClockInfo>,
    /// The columns, in the order of the file.
    pub columns: Vec<ColumnInfo>,
}

/// Says what is in a log file. Of the map, separators, the column of time and its unit matter, and for a dataset of
/// many logs the rule that picks one.
///
/// ```
/// use fd_log::{LogMap, info};
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("run.csv");
/// std::fs::write(&path, "t,speed_rpm,on\n0,100,1\n0.5,,1\n1,120,1\n")?;
/// let found = info(&path, &LogMap::default())?;
/// assert_eq!((found.format.as_str(), found.tables[0].rows), ("CSV", 3));
/// assert_eq!(found.tables[0].columns[1].guess.as_deref(), Some("rpm"));
/// assert_eq!(found.tables[0].columns[2].doubts, ["never changes"]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// Returns an error when the file cannot be read to its end. Cells that are no numbers are counted, not refused.
pub fn info(path: impl AsRef<Path>, map: &LogMap) -> Result<LogInfo, LogError> {
    let (format, opened) = read(path.as_ref(), map)?;
    let mut info = LogInfo {
        file: path.as_ref().display().to_string(),
        format,
        sample_time: None,
        tables: Vec::new(),
        left: Vec::new(),
        notes: Vec::new(),
        doubts: Vec::new(),
    };
    match opened {
        Opened::Rows(source) => {
            info.sample_time = source.sample_time();
            info.notes = source.notes();
            info.tables.push(of_rows(source, map)?);
        }
        Opened::Columns(recording) => {
            info.sample_time = recording.sample_time;
            info.left = recording.unfit;
            info.tables = recording.topics.into_iter().map(|topic| of_topic(topic, map)).collect();
        }
    }
    let clocks = info.tables.iter().filter(|table| table.clock.is_some()).count();
    if clocks > 1 {
        info.doubts.push(format!(
            "{clocks} clocks: for columns of several of them, a column map must say `merge.clock` and `merge.max_age_s`"
        ));
    }
    let has_time = |table: &TableInfo| table.clock.is_some();
    if info.sample_time.is_none() && !info.tables.iter().any(has_time) {
        info.doubts.push(
            "no column is time: a column map must say `time.column` or `time.sample_time`"
                .to_owned(),
        );
    }
    Ok(info)
}

fn of_rows(mut source: Box<dyn LogSource>, map: &LogMap) -> Result<TableInfo, LogError> {
    let header = source.columns().to_vec();
    let time = time_column(&header, source.date_column(), map);
    let mut tallies: Vec<Tally> = header.iter().map(|_| Tally::default()).collect();
    let mut times = Vec::new();
    let mut rows = 0_usize;
    let mut left = Budget::new(source.file());
    while source.next_row()?.is_some() {
        // Times are kept, and sorted once more.
        left.take_rows("times of the log", rows, 16)?;
        rows += 1;
        for (index, tally) in tallies.iter_mut().enumerate() {
            match source.number(index) {
                Ok(number) => tally.number(number),
                Err(LogError::Number { found, .. }) => tally.text(&found),
                Err(error) => return Err(error),
            }
        }
        if let Some(Ok(number)) = time.map(|time| source.number(time)) {
            times.push(number);
        }
    }
    let clock = time.map(|index| clock_of(&header[index], times, map));
    let columns = header.iter().zip(tallies).map(|(column, tally)| tally.of(column)).collect();
    Ok(TableInfo { name: String::new(), rows, clock, columns })
}

fn of_topic(topic: Topic, map: &LogMap) -> TableInfo {
    let rows = topic.rows();
    let time = time_column(&topic.columns, None, map);
    let clock = match (time, &topic.times) {
        (Some(index), _) => Some(clock_of(&topic.columns[index], topic.values[index].clone(), map)),
        (None, Some(times)) => Some(ClockInfo::new("", times.clone())),
        (None, None) => None,
    };
    let column = |(header, values): (&HeaderColumn, &Vec<f64>)| {
        let mut tally = Tally::default();
        for value in values {
            tally.number(*value);
        }
        tally.of(header)
    };
    let columns = topic.columns.iter().zip(&topic.values).map(column).collect();
    TableInfo { name: topic.name, rows, clock, columns }
}

/// The clock in a column, in seconds by the unit of the map, else by that of the header.
fn clock_of(header: &HeaderColumn, mut times: Vec<f64>, map: &LogMap) -> ClockInfo {
    let unit = map.time.unit.as_deref().or(header.unit.as_deref());
    let seconds = fd_model::unit::Conversion::between(unit.unwrap_or("s"), "s");
    if let Ok(seconds) = &seconds {
        for time in &mut times {
            *time = seconds.apply(*time);
        }
    }
    let mut clock = ClockInfo::new(&header.text, times);
    if let Err(error) = seconds {
        clock.doubts.push(format!("{error}: read as seconds here"));
    } else if unit.is_none() {
        clock.doubt_seconds();
    }
    clock
}
