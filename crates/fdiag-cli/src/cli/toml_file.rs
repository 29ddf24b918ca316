//! Settings from TOML files.

use std::{fs, path::Path};

use serde::de::DeserializeOwned;

use super::failure::Failure;

/// Reads a file of settings; the message of a wrong one shows the line.
pub(crate) fn read<T: DeserializeOwned>(file: &Path) -> Result<T, Failure> {
    let text = fs::read_to_string(file).map_err(|e| Failure::input(file, e))?;
    toml::from_str(&text).map_err(|e| Failure::input(file, e))
}
