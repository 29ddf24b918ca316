//! How much memory a log may take.

use std::fs::File;

use fd_core::memory::{self, MemoryError};

use crate::error::LogError;

/// Most bytes of the unpacked text of a packed file.
pub const MOST_BYTES: u64 = memory::MOST;

/// What a file may claim however short it is.
#[allow(dead_code, reason = "only readers of columns need it, and each is a feature")]
const FREE: u64 = 64 << 20;
/// Bytes that a byte of Deflate can become at most (1032), and a little for what is around it.
#[allow(dead_code, reason = "only readers of columns need it, and each is a feature")]
const INFLATED: u64 = 1100;

/// Rows that memory is taken for at a time.
const BLOCK: usize = 1 << 10;

/// What is left of the [budget of memory](fd_core::memory) while a file is read.
#[derive(Clone, Debug, Default)]
pub(crate) struct Budget {
    file: String,
    left: memory::Budget,
}

#[allow(dead_code, reason = "only readers of columns need all of it, and each is a feature")]
impl Budget {
    /// The whole of it.
    pub(crate) fn new(file: &str) -> Self {
        Self { file: file.to_owned(), left: memory::Budget::default() }
    }

    /// The same, and no more than the bytes of the file can stand for where nothing packs better than Deflate: what a
    /// file claims beyond that was never written into it.
    pub(crate) fn of_file(file: &str, from: &File) -> Self {
        let length = from.metadata().map_or(0, |about| about.len());
        let most = FREE.saturating_add(length.saturating_mul(INFLATED));
        Self { file: file.to_owned(), left: memory::Budget::of(memory::budget().min(most)) }
    }

    /// What is left, in bytes.
    pub(crate) fn left(&self) -> u64 {
        self.left.left()
    }

    /// The error of this file where the system has no memory.
    pub(crate) fn refused(&self, error: MemoryError) -> LogError {
        LogError::TooLarge { file: self.file.clone(), error }
    }

    /// Takes bytes for a part of the file, before they are asked of the system.
    pub(crate) fn take(&mut self, what: &str, bytes: u64) -> Result<(), LogError> {
        self.left.take(what, bytes).map_err(|error| self.refused(error))
    }

    /// Takes bytes for the rows from this one on, so many per row, where the row is the first of a [`BLOCK`].
    pub(crate) fn take_rows(
        &mut self,
        what: &str,
        row: usize,
        bytes: usize,
    ) -> Result<(), LogError> {
        if row.is_multiple_of(BLOCK) { self.take(what, (bytes * BLOCK) as u64) } else { Ok(()) }
    }
}
