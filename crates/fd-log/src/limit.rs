//! How much memory a log may take.

use crate::error::LogError;

/// Most bytes of a log: of the unpacked text of a packed file, or of the numbers that are held in memory.
pub const MOST_BYTES: u64 = 4 << 30;

/// What is left of [`MOST_BYTES`] while a file is read.
#[derive(Clone, Debug, Default)]
#[allow(dead_code, reason = "only readers of columns need it, and each is a feature")]
pub(crate) struct Budget {
    file: String,
    left: u64,
}

#[allow(dead_code, reason = "only readers of columns need it, and each is a feature")]
impl Budget {
    /// The whole of it.
    pub(crate) fn new(file: &str) -> Self {
        Self { file: file.to_owned(), left: MOST_BYTES }
    }

    /// Takes bytes for a part of the file, before they are asked of the system.
    pub(crate) fn take(&mut self, what: &str, bytes: u64) -> Result<(), LogError> {
        self.left = self.left.checked_sub(bytes).ok_or_else(|| LogError::TooLarge {
            file: self.file.clone(),
            what: what.to_owned(),
            most: self.left,
            found: bytes,
        })?;
        Ok(())
    }
}
