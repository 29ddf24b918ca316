//! What a file of settings says.

use std::{fmt::Display, path::Path};

use super::failure::Failure;

/// What a file of settings says, where one is given.
pub(super) fn given<T, E: Display>(
    file: Option<&Path>,
    read: impl FnOnce(&Path) -> Result<T, E>,
) -> Result<Option<T>, Failure> {
    file.map(read).transpose().map_err(Failure::of_input)
}
