//! Files that people try and that have no reader here: what they are, and how they become one that has.

use crate::error::LogError;

/// First bytes, name, and the way out.
type Foreign = (&'static [u8], &'static str, &'static str);

const MAGIC: &[Foreign] = &[
    (
        b"#ROSBAG V",
        "a recording of ROS 1",
        "convert it to MCAP: `mcap convert run.bag run.mcap` keeps it as ROS 1, `rosbags-convert --src run.bag --dst run` \
         makes it one of ROS 2",
    ),
    (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "a file of old Office (.xls)", "save the sheet as CSV"),
    (b"TDSm", "TDMS of LabVIEW", "export it as CSV, or with npTDMS as HDF5"),
    (b"MDF     ", "MDF of measurement tools", "export it with asammdf as CSV, HDF5 or MAT"),
    (
        b"ARROW1\0\0",
        "Arrow (Feather)",
        "write it as Parquet or CSV: `pandas.read_feather(file).to_csv(...)`",
    ),
    (b"\xff\xff\xff\xff", "an Arrow stream", "write it as Parquet or CSV"),
    (b"\x80\x02", "a pickle", PICKLE),
    (b"\x80\x03", "a pickle", PICKLE),
    (b"\x80\x04", "a pickle", PICKLE),
    (b"\x80\x05", "a pickle", PICKLE),
    (b"# Created by Octave", "text of Octave", "save it with `save -v7 run.mat ...`"),
    (b"%PDF", "a PDF", "export the numbers as CSV"),
    (b"LOGG", "a log of a CAN bus (BLF)", "decode its signals to CSV first"),
];

const PICKLE: &str =
    "pickles run code when they are loaded; write the arrays with `numpy.savez`, or a frame as CSV";

/// What is in a zip archive: the end of a name in it, what it is, and the way out.
#[cfg(feature = "npz")]
const ARCHIVES: &[(&str, &str, &str)] = &[
    (
        "data.pkl",
        "a file of PyTorch",
        "write its tensors as arrays: `numpy.savez(\"run.npz\", **{name: t.numpy() for name, t in data.items()})`",
    ),
    ("xl/workbook.xml", "a workbook of Excel", "save the sheet as CSV"),
    ("content.xml", "an OpenDocument file", "save the sheet as CSV"),
    ("modelDescription.xml", "an FMU", "that is a model; a log is what a plant did"),
    ("word/document.xml", "a document of Word", "export the numbers as CSV"),
];

/// The error for a file that begins so; nothing where it may be read.
pub(super) fn of_bytes(file: &str, first: &[u8]) -> Option<LogError> {
    let (_, format, way_out) = MAGIC.iter().find(|(magic, ..)| first.starts_with(magic))?;
    Some(error(file, format, way_out))
}

/// The error for an archive without arrays, by the names in it.
#[cfg(feature = "npz")]
pub(super) fn of_archive<'a>(
    file: &str,
    mut names: impl Iterator<Item = &'a str>,
) -> Option<LogError> {
    let known = |name: &str| ARCHIVES.iter().find(|(end, ..)| name.ends_with(end));
    let (_, format, way_out) = names.find_map(known)?;
    Some(error(file, format, way_out))
}

fn error(file: &str, format: &str, way_out: &str) -> LogError {
    let found = format!("found {format}, which is not read: {way_out}");
    LogError::NoLog { file: file.to_owned(), expected: "a log", found }
}
