//! Writing of records as logs.

use std::{
    collections::BTreeSet,
    io::{self, Write},
    path::Path,
};

use fd_model::{
    Channel, Record,
    file::{FileAction, write_atomically},
};

use crate::{error::LogError, header::HeaderColumn};

const TIME: &str = "time";

/// Writes a record as a log, completely or not at all.
///
/// Reading it back with [`LogMap::for_channels`](crate::LogMap::for_channels) of the
/// record's channels gives the same record to the bit.
///
/// # Errors
///
/// Returns an error when the file cannot be written, two channels have one name or one is called
/// `time`, or the name or unit of a channel cannot stand in a header.
pub fn write_log(path: impl AsRef<Path>, record: &Record) -> Result<(), LogError> {
    let path = path.as_ref();
    let file = path.display().to_string();
    check(&file, record)?;
    write_atomically(path, |out| write_rows(out, record))
        .map_err(|error| cannot_write(&file, &error))
}

/// Writes a record as a log to anywhere; `file` is the name for errors.
///
/// ```
/// # use fd_log::write_log_to;
/// # use fd_model::{Channel, Record, SampleTime};
/// let (wf, t7) = (Channel::new("wf", "kg/s"), Channel::new("T_7", "K"));
/// let (u, y) = (vec![0.25, 0.25], vec![900.0, f64::NAN]);
/// let record = Record::new(vec![wf], vec![t7], u, y, SampleTime::new(0.5)?)?;
/// let mut csv = Vec::new();
/// write_log_to("run.csv", &mut csv, &record)?;
/// let expected = "\
/// ## fdiag-log version=1 sample_time=0.5
/// time [s],wf [kg/s],T_7 [K]
/// 0.0,0.25,900.0
/// 0.5,0.25,
/// ";
/// assert_eq!(String::from_utf8(csv)?, expected);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// As [`write_log`].
pub fn write_log_to(file: &str, out: &mut dyn Write, record: &Record) -> Result<(), LogError> {
    check(file, record)?;
    write_rows(out, record).map_err(|error| cannot_write(file, &error))
}

fn check(file: &str, record: &Record) -> Result<(), LogError> {
    let mut names = BTreeSet::from([TIME]);
    for channel in record.inputs().iter().chain(record.outputs()) {
        if !names.insert(&channel.name) {
            let (file, column) = (file.to_owned(), channel.name.clone());
            return Err(LogError::DuplicateColumn { file, column });
        }
        let header = header(channel);
        let read = HeaderColumn::parse(&header);
        if read.name != channel.name || read.unit.as_deref() != Some(channel.unit.as_str()) {
            let Channel { name, unit, .. } = channel.clone();
            return Err(LogError::Unwritable { file: file.to_owned(), header, name, unit });
        }
    }
    Ok(())
}

fn header(channel: &Channel) -> String {
    channel.to_string()
}

fn write_rows(out: &mut dyn Write, record: &Record) -> io::Result<()> {
    writeln!(out, "# fdiag-log version=1 sample_time={:?}", record.ts().seconds())?;
    let mut csv = csv::Writer::from_writer(out);
    let channels = record.inputs().iter().chain(record.outputs());
    csv.write_record(std::iter::once(format!("{TIME} [s]")).chain(channels.map(header)))?;
    for (k, (u, y)) in record.samples().enumerate() {
        let values = u.iter().chain(y).map(|&v| cell(v));
        csv.write_record(std::iter::once(cell(record.time(k))).chain(values))?;
    }
    csv.flush()
}

/// The shortest text that is read back as the same number; nothing for a missing value.
fn cell(value: f64) -> String {
    if value.is_finite() { format!("{value:?}") } else { String::new() }
}

fn cannot_write(file: &str, error: &io::Error) -> LogError {
    LogError::Io { file: file.to_owned(), action: FileAction::Write, kind: error.kind() }
}
