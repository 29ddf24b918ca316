//! Arrays of numpy: NPZ archives and single NPY files,
//! <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>.
//!
//! Arrays whose first dimensions are equally long are one table: a vector is a column under its name, a matrix
//! has columns `name[0]`, `name[1]`... , an array of records one per field. Dates (`datetime64`) become seconds
//! since the first of them. Objects are never loaded; texts, single values and arrays of more than two
//! dimensions are named and left.

mod array;
mod literal;

use std::{fs::File, io::Read};

use flate2::read::DeflateDecoder;
use rawzip::{CompressionMethod, ZipArchive};

use self::array::NoArray;
use super::foreign;
use crate::{
    error::LogError,
    limit::Budget,
    recording::{Recording, Topic},
};

/// What the array of a file without names is called.
const UNNAMED: &str = "arr";
/// Room for what the directory of an archive says of one array.
const ENTRY: usize = 1 << 17;

/// A single array.
pub(super) fn read_array(file: &str, mut from: File) -> Result<Recording, LogError> {
    let mut recording = Recording { file: file.to_owned(), ..Recording::default() };
    let mut left = Budget::of_file(file, &from);
    let read = array::read(UNNAMED, &mut from, &mut left);
    add(&mut recording, UNNAMED, read)?;
    Ok(recording)
}

/// An archive of arrays.
pub(super) fn read_archive(file: &str, from: File) -> Result<Recording, LogError> {
    let damaged = |error: rawzip::Error| LogError::Damaged {
        file: file.to_owned(),
        format: "NPZ",
        found: format!("found: {error}"),
    };
    let mut recording = Recording { file: file.to_owned(), ..Recording::default() };
    let mut left = Budget::of_file(file, &from);
    let mut buffer = vec![0; ENTRY];
    let archive = ZipArchive::from_file(from, &mut buffer).map_err(damaged)?;
    let mut entries = archive.entries(&mut buffer);
    while let Some(entry) = entries.next_entry().map_err(damaged)? {
        let path = String::from_utf8_lossy(entry.file_path().as_ref()).into_owned();
        let method = entry.compression_method();
        let Some(name) = path.strip_suffix(".npy") else {
            recording.unfit.push((path, "something else than an array".to_owned()));
            continue;
        };
        let local = archive.get_entry(entry.wayfinder()).map_err(damaged)?;
        let mut packed: Box<dyn Read> = match method {
            CompressionMethod::STORE => Box::new(local.verifying_reader(local.reader())),
            CompressionMethod::DEFLATE => {
                Box::new(local.verifying_reader(DeflateDecoder::new(local.reader())))
            }
            other => {
                let found = format!("found `{path}` packed by method {}", other.as_u16());
                let file = file.to_owned();
                return Err(LogError::Damaged { file, format: "NPZ", found });
            }
        };
        let read = array::read(name, &mut packed, &mut left).and_then(|topic| {
            // The checksum is compared at the end, and nothing may stand behind the array.
            match packed.read(&mut [0])? {
                0 => Ok(topic),
                _ => Err(NoArray::Unsound(format!("found more than the array in `{path}`"))),
            }
        });
        add(&mut recording, name, read)?;
    }
    if recording.topics.is_empty() {
        let names = recording.unfit.iter().map(|(name, _)| name.as_str());
        if let Some(error) = foreign::of_archive(file, names) {
            return Err(error);
        }
    }
    recording.with_columns("arrays of numbers")
}

/// Puts an array into the table of its length.
fn add(
    recording: &mut Recording,
    name: &str,
    read: Result<Topic, NoArray>,
) -> Result<(), LogError> {
    match read {
        Ok(topic) => {
            recording.add_table(topic);
            Ok(())
        }
        Err(NoArray::Unfit(what)) => {
            recording.unfit.push((name.to_owned(), what));
            Ok(())
        }
        Err(NoArray::Large(error)) => Err(error),
        Err(NoArray::Unsound(found)) => {
            let file = recording.file.clone();
            Err(LogError::Damaged { file, format: "NPY", found })
        }
    }
}
