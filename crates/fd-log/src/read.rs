//! A log, read as a whole from a file or a text.

use std::{io::Read, path::Path};

use crate::{
    error::LogError,
    format::{CsvSource, open},
    map::LogMap,
    reader::{Log, LogReader},
};

/// Reads a log and puts it on an even time base. The ending of its name says the [format](crate::FORMATS).
///
/// # Errors
///
/// Returns an error with the place in the file when the file cannot be read, columns are missing
/// or have the wrong unit, a cell is not a number, or time does not increase.
pub fn read_log(path: impl AsRef<Path>, map: &LogMap) -> Result<Log, LogError> {
    LogReader::new(open(path, map)?, map)?.read_all()
}

/// Reads a log as CSV from anywhere; `file` is the name for errors.
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
    LogReader::new(CsvSource::new(file, from, map)?, map)?.read_all()
}
