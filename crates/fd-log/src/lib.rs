//! Reading and writing of log files; `docs/formats.md` describes the formats.
//!
//! | What | Read | Write |
//! |------|------|-------|
//! | record | [`read_log`] with a [`LogMap`] | [`write_log`] |
//! | huge log, row by row | [`LogReader`] | |
//! | log in memory | [`LogTable`] | |
//! | contents of a file | [`info`](fn@info) | |
//!
//! | feature | formats |
//! |---------|---------|
//! | `packed` | CSV and NDJSON in gzip and Zstandard |
//! | `npz` | arrays of numpy |
//! | `mcap` | recordings of ROS 2 in MCAP |
//! | `rosbag` | recordings of ROS 2 in `SQLite` |
//! | `ulog` | flight logs of PX4 |
//! | `hdf5` | HDF5, and MAT-files of version 7.3 |
//! | `mat` | MAT-files of version 5 |
//! | `parquet` | Parquet, and datasets of `LeRobot` |
//!
//! A format is one source file that produces a [`LogSource`] or a [`Recording`], and an entry in the list of
//! [`FORMATS`] beside it.
//!
//! The names and units of the columns of a file are usually not those of the channels of a model. A column map
//! relates them, and the resulting record has the channels of the model:
//!
//! ```
//! use fd_log::{LogMap, read_log_from, write_log_to};
//! use fd_model::Channel;
//!
//! let map: LogMap = toml::from_str(
//!     r#"
//!     inputs = [{ name = "wf", unit = "kg/s", column = "Fuel" }]
//!     outputs = [{ name = "T_7", unit = "K", column = "EGT" }]
//!     "#,
//! )?;
//! let csv = "t,Fuel [g/s],EGT [degC]\n0,250,600\n0.5,251,\n1,252,602\n";
//! let record = read_log_from("monday.csv", csv.as_bytes(), &map)?.record;
//! assert_eq!(record.inputs(), [Channel::new("wf", "kg/s")]);
//! assert!((record.u(2)[0] - 0.252).abs() < 1e-15 && (record.y(0)[0] - 873.15).abs() < 1e-12);
//! assert!(record.y(1)[0].is_nan(), "an empty cell is a missing sample");
//!
//! // Written by us it needs no map, and comes back to the bit.
//! let mut written = Vec::new();
//! write_log_to("again.csv", &mut written, &record)?;
//! let map = LogMap::for_channels(record.inputs(), record.outputs());
//! let again = read_log_from("again.csv", written.as_slice(), &map)?.record;
//! assert_eq!(again.y(2)[0].to_bits(), record.y(2)[0].to_bits());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod column;
mod columns;
mod date;
mod derived;
mod error;
mod expression;
mod format;
mod header;
mod hints;
mod info;
mod limit;
mod map;
mod plain;
mod read;
mod reader;
mod recording;
mod source;
mod table;
mod time_map;
mod writer;

pub use self::{
    error::LogError,
    format::{CsvSource, FORMATS, LogFormat, NdjsonSource, format_of, open},
    header::HeaderColumn,
    info::{ClockInfo, ColumnInfo, LogInfo, TableInfo, info},
    limit::MOST_BYTES,
    map::{ColumnMap, FileRows, LogMap, MergeMap, RowRule},
    read::{read_log, read_log_from},
    reader::{Log, LogReader, LogRow},
    recording::{Recording, Topic},
    source::LogSource,
    table::LogTable,
    time_map::{DateOrder, TimeMap},
    writer::{write_log, write_log_to},
};

#[cfg(test)]
mod tests;
