//! What is said of a damaged file.

use crate::error::LogError;

pub(super) fn damaged(file: &str, found: &str) -> LogError {
    LogError::Damaged { file: file.to_owned(), format: "MAT", found: found.to_owned() }
}
