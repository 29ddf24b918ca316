//! Samples on the disk before their source is told that it may forget them.
//!
//! ```text
//! DIR/samples/N.ndjson    one sample per line, in the order in which they came; a file is closed when it is large, and
//!                         removed once every unit that it can be about has been saved
//! ```

use std::{
    fs::{self, File, OpenOptions},
    io::{self, BufRead, BufReader, Write},
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};

use crate::{bits, input::Row};

/// A file that is larger is closed.
const LARGE: u64 = 8 << 20;

/// A sample as it is kept.
#[derive(Serialize, Deserialize)]
struct Kept {
    unit: String,
    #[serde(with = "bits::one")]
    time: f64,
    #[serde(with = "bits::many")]
    values: Vec<f64>,
}

/// Samples that came and whose units may not have been saved since.
#[derive(Debug)]
pub(super) struct Intake {
    folder: PathBuf,
    /// The file that is written, its number and its length; made when there is something to write.
    current: Option<File>,
    number: u64,
    length: u64,
    /// Closed files, oldest first, and how many savings there have to be before each is of no use.
    closed: Vec<(u64, u64)>,
    lines: String,
}

impl Intake {
    /// Opens the folder. What earlier runs left is closed, and of use until `needed` savings are made.
    pub(super) fn open(folder: PathBuf) -> io::Result<Self> {
        fs::create_dir_all(&folder)?;
        let mut numbers: Vec<u64> = Vec::new();
        for entry in fs::read_dir(&folder)? {
            let name = entry?.file_name();
            let stem = name.to_str().and_then(|name| name.strip_suffix(".ndjson"));
            numbers.extend(stem.and_then(|stem| stem.parse::<u64>().ok()));
        }
        numbers.sort_unstable();
        let number = numbers.last().map_or(0, |last| last + 1);
        // Not before the samples have been taken again: see `replayed`.
        let closed = numbers.into_iter().map(|number| (number, u64::MAX)).collect();
        Ok(Self { folder, current: None, number, length: 0, closed, lines: String::new() })
    }

    fn path(&self, number: u64) -> PathBuf {
        self.folder.join(format!("{number}.ndjson"))
    }

    /// Files of earlier runs, oldest first.
    pub(super) fn left(&self) -> Vec<PathBuf> {
        self.closed.iter().map(|(number, _)| self.path(*number)).collect()
    }

    /// All files of earlier runs have been taken again; they are of use until `needed` savings are made.
    pub(super) fn replayed(&mut self, needed: u64) {
        for (_, until) in &mut self.closed {
            *until = needed;
        }
    }

    /// Adds a sample, to be written by [`Intake::secure`].
    pub(super) fn add(&mut self, row: Row<'_>) {
        let kept = Kept { unit: row.unit.to_owned(), time: row.time, values: row.values.to_vec() };
        // Numbers and a name: there is nothing that JSON cannot say.
        self.lines.push_str(&serde_json::to_string(&kept).unwrap_or_default());
        self.lines.push('\n');
    }

    /// Writes what was added, and waits until it is on the disk. `needed` is the number of savings after which all
    /// units that are waiting now will have been saved.
    pub(super) fn secure(&mut self, needed: u64) -> io::Result<()> {
        if self.lines.is_empty() {
            return Ok(());
        }
        let file = match &mut self.current {
            Some(file) => file,
            empty => {
                let path = self.folder.join(format!("{}.ndjson", self.number));
                let file = OpenOptions::new().append(true).create(true).open(path)?;
                File::open(&self.folder)?.sync_all()?;
                empty.insert(file)
            }
        };
        let written = file.write_all(self.lines.as_bytes()).and_then(|()| file.sync_data());
        if let Err(error) = written {
            // What is there of these lines was not promised; they are written as a whole when it is tried again.
            let _ = file.set_len(self.length);
            return Err(error);
        }
        self.length += self.lines.len() as u64;
        self.lines.clear();
        if LARGE <= self.length {
            self.close(needed);
        }
        Ok(())
    }

    /// Closes the file that is written.
    pub(super) fn close(&mut self, needed: u64) {
        if self.current.take().is_some() {
            self.closed.push((self.number, needed));
            self.number += 1;
            self.length = 0;
        }
    }

    /// A unit could not be saved and waits anew: nothing is of no use before `needed` savings.
    pub(super) fn keep_until(&mut self, needed: u64) {
        for (_, until) in self.closed.iter_mut().filter(|(_, until)| *until != u64::MAX) {
            *until = needed.max(*until);
        }
    }

    /// Removes files that are of no use after so many savings.
    pub(super) fn clean(&mut self, savings: u64) {
        let folder = self.folder.clone();
        self.closed.retain(|(number, until)| {
            let is_of_use = savings < *until;
            // One that cannot be removed costs room and time, and does no harm: its samples are no news.
            is_of_use || fs::remove_file(folder.join(format!("{number}.ndjson"))).is_err()
        });
    }
}

/// Reads the samples of a file. A last line without an end was not promised.
pub(super) fn read<E>(
    path: &Path,
    mut take: impl FnMut(Row<'_>) -> Result<(), E>,
) -> Result<Result<(), E>, ReadError> {
    let mut reader = BufReader::new(File::open(path)?);
    let mut line = Vec::new();
    for number in 1_u64.. {
        line.clear();
        reader.read_until(b'\n', &mut line)?;
        if line.last() != Some(&b'\n') {
            break;
        }
        let kept: Kept = serde_json::from_slice(&line)
            .map_err(|error| ReadError::Line(number, error.to_string()))?;
        let row = Row { unit: &kept.unit, time: kept.time, values: &kept.values };
        if let Err(error) = take(row) {
            return Ok(Err(error));
        }
    }
    Ok(Ok(()))
}

/// Why kept samples cannot be read.
pub(super) enum ReadError {
    Io(io::Error),
    Line(u64, String),
}

impl From<io::Error> for ReadError {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}
