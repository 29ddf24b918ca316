//! A file of finished pieces of work, one line of JSON each, that a killed run leaves readable.

use std::{
    fs::{self, File, OpenOptions, TryLockError},
    io::Write,
    path::{Path, PathBuf},
    sync::{Mutex, PoisonError},
};

use serde::{Serialize, de::DeserializeOwned};
use thiserror::Error;

/// A journal cannot be read or written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum JournalError {
    /// The file system.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What it said.
        source: std::io::Error,
    },
    /// Another run is writing it.
    #[error(
        "{}: another run is writing this file; wait until it has ended, or choose another directory",
        path.display()
    )]
    Busy {
        /// The file.
        path: PathBuf,
    },
    /// A line before the last is not what this program writes.
    #[error("{}, line {line}: {reason}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// Number of the line, from 1.
        line: usize,
        /// What is wrong with it.
        reason: String,
    },
}

/// A journal that lines can be added to, from any thread.
#[derive(Debug)]
pub(crate) struct Journal {
    path: PathBuf,
    file: Mutex<File>,
}

impl Journal {
    /// Opens a journal or begins it, and keeps others from opening it until it is dropped. What a
    /// killed run left of a line is cut off.
    pub(crate) fn open(path: &Path) -> Result<Self, JournalError> {
        let file = held(path)?;
        mend(path)?;
        Ok(Self { path: path.to_owned(), file: Mutex::new(file) })
    }

    /// Adds a line.
    pub(crate) fn append(&self, entry: &impl Serialize) -> Result<(), JournalError> {
        let reason = |error: serde_json::Error| JournalError::Line {
            path: self.path.clone(),
            line: 0,
            reason: error.to_string(),
        };
        let mut line = serde_json::to_string(entry).map_err(reason)?;
        line.push('\n');
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        file.write_all(line.as_bytes()).map_err(io(&self.path))
    }
}

/// All whole lines of a journal; none if there is no file.
pub(crate) fn read<T: DeserializeOwned>(path: &Path) -> Result<Vec<T>, JournalError> {
    if !path.exists() {
        return Ok(Vec::new());
    }
    let text = fs::read_to_string(path).map_err(io(path))?;
    let whole = text.rfind('\n').map_or("", |end| &text[..end]);
    let parse = |(i, line)| {
        serde_json::from_str(line).map_err(|error| JournalError::Line {
            path: path.to_owned(),
            line: i + 1,
            reason: error.to_string(),
        })
    };
    whole.lines().enumerate().map(parse).collect()
}

/// Forgets all that a journal holds, if nobody is writing it.
pub(crate) fn restart(path: &Path) -> Result<(), JournalError> {
    if path.exists() { held(path)?.set_len(0).map_err(io(path)) } else { Ok(()) }
}

/// The file, locked: the lock ends with the file or the process, however that ends.
fn held(path: &Path) -> Result<File, JournalError> {
    let file = OpenOptions::new().create(true).append(true).open(path).map_err(io(path))?;
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Err(JournalError::Busy { path: path.to_owned() }),
        // A file system without locks.
        Err(TryLockError::Error(_)) | Ok(()) => Ok(file),
    }
}

fn mend(path: &Path) -> Result<(), JournalError> {
    let Ok(text) = fs::read(path) else { return Ok(()) };
    let whole = text.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
    if whole == text.len() {
        return Ok(());
    }
    let file = OpenOptions::new().write(true).open(path).map_err(io(path))?;
    file.set_len(whole as u64).map_err(io(path))
}

fn io(path: &Path) -> impl Fn(std::io::Error) -> JournalError {
    let path = path.to_owned();
    move |source| JournalError::File { path: path.clone(), source }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_torn_line_is_forgotten_and_a_wrong_one_is_an_error() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("journal.jsonl");
        assert!(read::<u32>(&path).unwrap().is_empty());
        let journal = Journal::open(&path).unwrap();
        journal.append(&1_u32).unwrap();
        journal.append(&22_u32).unwrap();
        drop(journal);
        let whole = fs::read(&path).unwrap();
        fs::write(&path, [&whole[..], b"3"].concat()).unwrap();
        assert_eq!(read::<u32>(&path).unwrap(), [1, 22]);
        let held = Journal::open(&path).unwrap();
        for refused in [Journal::open(&path).map(drop), restart(&path)] {
            let error = refused.unwrap_err();
            assert!(matches!(error, JournalError::Busy { .. }), "{error}");
        }
        drop(held);
        Journal::open(&path).unwrap().append(&4_u32).unwrap();
        assert_eq!(read::<u32>(&path).unwrap(), [1, 22, 4]);
        fs::write(&path, "1\nno\n2\n").unwrap();
        let error = read::<u32>(&path).unwrap_err();
        assert!(matches!(error, JournalError::Line { line: 2, .. }), "{error}");
        restart(&path).unwrap();
        assert!(read::<u32>(&path).unwrap().is_empty());
    }
}
