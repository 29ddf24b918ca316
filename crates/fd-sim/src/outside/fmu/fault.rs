//! What is said of an FMU that is wrong.

use super::super::error::OutsideError;

/// What was expected of it, or of a part of it.
pub(super) fn fault(file: &str, what: &str, expected: &str, found: &str) -> OutsideError {
    OutsideError::Fmu {
        file: file.to_owned(),
        what: what.to_owned(),
        expected: expected.to_owned(),
        found: found.to_owned(),
    }
}
