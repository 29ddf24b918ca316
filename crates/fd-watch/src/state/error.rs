//! Why a state cannot be used.

use std::{
    io,
    path::{Path, PathBuf},
};

use thiserror::Error;

use crate::memory::MemoryError;

/// The state cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StateError {
    /// The operating system does not let a file be read or written.
    #[error("cannot {action} {}: {source}", path.display())]
    Io {
        /// What was to be done.
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// Why not.
        source: io::Error,
    },
    /// Another monitor runs on it.
    #[error("{}: another monitor runs on this state", path.display())]
    Locked {
        /// The folder.
        path: PathBuf,
    },
    /// It belongs to something else.
    #[error(
        "{}: the state was made with another {what} ({found}, now {expected}); choose another folder, or \
         remove this one to begin anew", path.display()
    )]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What differs.
        what: &'static str,
        /// What is expected.
        expected: String,
        /// What is there.
        found: String,
    },
    /// A file is not what was saved.
    #[error("{}: {reason}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// A unit cannot be put back.
    #[error("{}: {source}", path.display())]
    Memory {
        /// Its file.
        path: PathBuf,
        /// Why.
        source: Box<MemoryError>,
    },
}

pub(super) fn io_error(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> StateError {
    let path = path.to_owned();
    move |source| StateError::Io { action, path, source }
}
