//! The formats that can be read: one list, from the name and the first bytes of a file to a source.

#[cfg(feature = "rosbag")]
mod bag;
mod bounded;
mod csv;
mod foreign;
#[cfg(feature = "hdf5")]
mod hdf5;
#[cfg(feature = "mat")]
mod mat;
#[cfg(feature = "mcap")]
mod mcap;
#[cfg(any(feature = "mcap", feature = "rosbag", feature = "ulog"))]
mod message;
mod ndjson;
#[cfg(feature = "npz")]
mod npz;
#[cfg(any(feature = "npz", feature = "hdf5", feature = "mat"))]
mod number;
#[cfg(feature = "packed")]
mod packed;
#[cfg(feature = "parquet")]
mod parquet;
#[cfg(feature = "ulog")]
mod ulog;
#[cfg(any(feature = "packed", feature = "mcap"))]
mod zstd;

use std::{
    fs::File,
    io::{Cursor, Read, Seek},
    path::Path,
};

use self::bounded::Bounded;
pub use self::{csv::CsvSource, ndjson::NdjsonSource};
use crate::{
    error::LogError,
    map::LogMap,
    recording::Recording,
    source::{LogSource, cannot_read},
};

/// A format of log files.
#[derive(Clone, Copy, Debug)]
pub struct LogFormat {
    /// Name, as people say it.
    pub name: &'static str,
    /// Endings of file names, in lower case.
    pub extensions: &'static [&'static str],
    /// First bytes of a file, where the format has such.
    pub magic: &'static [&'static [u8]],
    /// Reads a file that is there.
    read: Reading,
}

/// Reads a header; rows follow.
type ReadText = fn(&str, Box<dyn Read>, &LogMap) -> Result<Box<dyn LogSource>, LogError>;

/// How a format is read; the text is the name of the file for errors.
#[derive(Clone, Copy, Debug)]
enum Reading {
    /// Line by line.
    Text(ReadText),
    /// Text inside, unpacked as it is read.
    #[cfg(feature = "packed")]
    Packed(fn(Box<dyn Read>) -> Box<dyn Read>),
    /// As a whole, column by column.
    #[allow(
        dead_code,
        reason = "each format that is one, or is not built, is a matter of a feature"
    )]
    Columns(fn(&str, File) -> Result<Recording, LogError>),
    /// Not in this program, for want of a feature.
    #[allow(
        dead_code,
        reason = "each format that is one, or is not built, is a matter of a feature"
    )]
    NotBuilt(&'static str),
}

/// All formats. The first one is meant where neither the name of a file nor its first bytes say another.
pub const FORMATS: &[LogFormat] = &[
    LogFormat {
        name: "CSV",
        extensions: &["csv", "tsv", "txt"],
        magic: &[],
        read: Reading::Text(|file, from, map| Ok(Box::new(CsvSource::new(file, from, map)?))),
    },
    LogFormat {
        name: "NDJSON",
        extensions: &["ndjson", "jsonl"],
        magic: &[],
        read: Reading::Text(|file, from, map| Ok(Box::new(NdjsonSource::new(file, from, map)?))),
    },
    LogFormat {
        name: "gzip",
        extensions: &["gz", "gzip"],
        magic: &[b"\x1f\x8b"],
        #[cfg(feature = "packed")]
        read: Reading::Packed(|from| packed::gzip(from)),
        #[cfg(not(feature = "packed"))]
        read: Reading::NotBuilt("packed"),
    },
    LogFormat {
        name: "Zstandard",
        extensions: &["zst", "zstd"],
        // A frame, and the first of the frames that hold no data.
        magic: &[b"\x28\xb5\x2f\xfd", b"\x50\x2a\x4d\x18"],
        #[cfg(feature = "packed")]
        read: Reading::Packed(|from| packed::zstd(from)),
        #[cfg(not(feature = "packed"))]
        read: Reading::NotBuilt("packed"),
    },
    LogFormat {
        name: "NPZ",
        extensions: &["npz"],
        magic: &[b"PK\x03\x04", b"PK\x05\x06"],
        #[cfg(feature = "npz")]
        read: Reading::Columns(npz::read_archive),
        #[cfg(not(feature = "npz"))]
        read: Reading::NotBuilt("npz"),
    },
    LogFormat {
        name: "NPY",
        extensions: &["npy"],
        magic: &[b"\x93NUMPY"],
        #[cfg(feature = "npz")]
        read: Reading::Columns(npz::read_array),
        #[cfg(not(feature = "npz"))]
        read: Reading::NotBuilt("npz"),
    },
    LogFormat {
        name: "Parquet",
        extensions: &["parquet"],
        magic: &[b"PAR1"],
        #[cfg(feature = "parquet")]
        read: Reading::Columns(parquet::read),
        #[cfg(not(feature = "parquet"))]
        read: Reading::NotBuilt("parquet"),
    },
    LogFormat {
        name: "MCAP",
        extensions: &["mcap"],
        magic: &[b"\x89MCAP0\r\n"],
        #[cfg(feature = "mcap")]
        read: Reading::Columns(mcap::read),
        #[cfg(not(feature = "mcap"))]
        read: Reading::NotBuilt("mcap"),
    },
    LogFormat {
        name: "rosbag2",
        extensions: &["db3"],
        magic: &[b"SQLite format 3\0"],
        #[cfg(feature = "rosbag")]
        read: Reading::Columns(bag::read),
        #[cfg(not(feature = "rosbag"))]
        read: Reading::NotBuilt("rosbag"),
    },
    LogFormat {
        name: "MAT 7.3",
        extensions: &[],
        magic: &[b"MATLAB 7.3 MAT"],
        #[cfg(feature = "hdf5")]
        read: Reading::Columns(hdf5::read_matlab),
        #[cfg(not(feature = "hdf5"))]
        read: Reading::NotBuilt("hdf5"),
    },
    LogFormat {
        name: "HDF5",
        extensions: &["h5", "hdf5", "hdf", "nc"],
        magic: &[b"\x89HDF\r\n\x1a\n"],
        #[cfg(feature = "hdf5")]
        read: Reading::Columns(hdf5::read),
        #[cfg(not(feature = "hdf5"))]
        read: Reading::NotBuilt("hdf5"),
    },
    LogFormat {
        name: "MAT",
        extensions: &["mat"],
        magic: &[b"MATLAB 5.0 MAT"],
        #[cfg(feature = "mat")]
        read: Reading::Columns(mat::read),
        #[cfg(not(feature = "mat"))]
        read: Reading::NotBuilt("mat"),
    },
    // Has no first bytes of its own: what is called MAT and is no other.
    LogFormat {
        name: "MAT 4",
        extensions: &["mat"],
        magic: &[],
        #[cfg(feature = "mat")]
        read: Reading::Columns(mat::read_v4),
        #[cfg(not(feature = "mat"))]
        read: Reading::NotBuilt("mat"),
    },
    LogFormat {
        name: "ULog",
        extensions: &["ulg", "ulog"],
        magic: &[b"ULog\x01\x12\x35"],
        #[cfg(feature = "ulog")]
        read: Reading::Columns(ulog::read),
        #[cfg(not(feature = "ulog"))]
        read: Reading::NotBuilt("ulog"),
    },
];

/// The format of a file, by the ending of its name.
///
/// ```
/// assert_eq!(fd_log::format_of("runs/monday.jsonl").name, "NDJSON");
/// assert_eq!(fd_log::format_of("runs/monday.log").name, "CSV");
/// ```
#[must_use]
pub fn format_of(path: impl AsRef<Path>) -> &'static LogFormat {
    named(path.as_ref()).next().unwrap_or(&FORMATS[0])
}

/// All formats with the ending of a name.
fn named(path: &Path) -> impl Iterator<Item = &'static LogFormat> {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    FORMATS.iter().filter(move |format| format.extensions.contains(&extension.as_str()))
}

/// Opens a log file as a table. Its first bytes say the format, and where they do not, the ending of its name.
///
/// # Errors
///
/// Returns an error when the file cannot be opened, does not begin as its format does, or - where a format is
/// read as a whole - does not have the columns of the map.
pub fn open(path: impl AsRef<Path>, map: &LogMap) -> Result<Box<dyn LogSource>, LogError> {
    match read(path.as_ref(), map)?.1 {
        Opened::Rows(source) => Ok(source),
        Opened::Columns(recording) => Ok(recording.into_table(map)?.into_source()),
    }
}

/// What a file is read as.
pub(crate) enum Opened {
    /// Rows one after the other.
    Rows(Box<dyn LogSource>),
    /// Columns, in memory.
    Columns(Recording),
}

/// Whether something is no file of any length: a terminal, a source of noise. A pipe is none of these.
fn is_device(file: &File) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        let kind = file.metadata().map(|about| about.file_type());
        kind.is_ok_and(|kind| kind.is_char_device() || kind.is_block_device())
    }
    #[cfg(not(unix))]
    {
        let _ = file;
        false
    }
}

/// Opens a file, and names its format.
pub(crate) fn read(path: &Path, map: &LogMap) -> Result<(String, Opened), LogError> {
    let file = path.display().to_string();
    let unreadable = |error| cannot_read(&file, &error);
    #[cfg(feature = "parquet")]
    if parquet::is_dataset(path) {
        let recording = parquet::read_dataset(path, map)?;
        return Ok(("LeRobot".to_owned(), Opened::Columns(recording)));
    }
    if path.is_dir() {
        let (expected, found) = ("a file", "found a folder".to_owned());
        let is_dataset = path.join("meta").join("info.json").is_file();
        let (format, feature) = ("LeRobot datasets", "parquet");
        return Err(if is_dataset {
            LogError::NotBuilt { file, format, feature }
        } else {
            LogError::NoLog { file, expected, found }
        });
    }
    if fd_model::file::is_named_pipe(path) {
        let (expected, found) = ("a file", fd_model::file::NAMED_PIPE.to_owned());
        return Err(LogError::NoLog { file, expected, found });
    }
    let mut from = File::open(path).map_err(unreadable)?;
    if is_device(&from) {
        let (expected, found) = ("a file", "found a device, which may never end".to_owned());
        return Err(LogError::NoLog { file, expected, found });
    }
    let mut first = Vec::new();
    (&mut from).take(MAGIC).read_to_end(&mut first).map_err(unreadable)?;
    let format = recognised(&file, &first, path)?;
    let name = format.name.to_owned();
    // Text is not wound back: a pipe has no way back.
    let text = |from: File| Box::new(Cursor::new(first.clone()).chain(from));
    match format.read {
        Reading::Text(read) => {
            let from = Box::new(Bounded::new(format.name, text(from), u64::MAX));
            Ok((name, Opened::Rows(read(&file, from, map)?)))
        }
        #[cfg(feature = "packed")]
        Reading::Packed(unpack) => {
            let inner = packed_format(path);
            let Reading::Text(read) = inner.read else {
                let (expected, found) = ("a packed text", format!("found {}", inner.name));
                return Err(LogError::NoLog { file, expected, found });
            };
            let rows = read(&file, unpack(text(from)), map)?;
            Ok((format!("{} in {name}", inner.name), Opened::Rows(rows)))
        }
        Reading::Columns(read) => {
            from.rewind().map_err(unreadable)?;
            Ok((name, Opened::Columns(read(&file, from)?)))
        }
        Reading::NotBuilt(feature) => {
            Err(LogError::NotBuilt { file, format: format.name, feature })
        }
    }
}

/// First bytes that are looked at.
const MAGIC: u64 = 20;

/// The format that begins with these bytes, else the one that the name says, if it may begin so. Where several begin
/// alike (archives), the name decides.
fn recognised(file: &str, first: &[u8], path: &Path) -> Result<&'static LogFormat, LogError> {
    let begins = |format: &&LogFormat| format.magic.iter().any(|magic| first.starts_with(magic));
    if let Some(format) = named(path).find(begins).or_else(|| FORMATS.iter().find(begins)) {
        return Ok(format);
    }
    if let Some(error) = foreign::of_bytes(file, first) {
        return Err(error);
    }
    if first.is_empty() {
        return Err(LogError::Empty { file: file.to_owned() });
    }
    let mut named = named(path).peekable();
    let expected = named.peek().map_or(FORMATS[0].name, |format| format.name);
    if expected == FORMATS[0].name {
        return Ok(&FORMATS[0]);
    }
    named.find(|format| format.magic.is_empty()).ok_or_else(|| {
        let found = format!("found `{}` at its beginning", first.escape_ascii());
        LogError::Damaged { file: file.to_owned(), format: expected, found }
    })
}

/// The format of what is packed: `run.ndjson.gz` holds NDJSON.
#[cfg(feature = "packed")]
fn packed_format(path: &Path) -> &'static LogFormat {
    let is_packed = |path: &Path| matches!(format_of(path).read, Reading::Packed(_));
    let inner = if is_packed(path) { path.with_extension("") } else { path.to_owned() };
    if is_packed(&inner) { &FORMATS[0] } else { format_of(inner) }
}
