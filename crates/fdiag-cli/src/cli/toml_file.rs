//! Settings from TOML files.

use std::path::Path;

use fdiag::model::file::read_settings;
use serde::de::DeserializeOwned;

use super::failure::Failure;

/// Reads a file of settings; the message of a wrong one names its line and key.
pub(crate) fn read<T: DeserializeOwned>(file: &Path) -> Result<T, Failure> {
    read_settings(file).map_err(Failure::of_input)
}
