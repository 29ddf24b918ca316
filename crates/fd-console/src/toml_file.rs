//! Settings from TOML files.

use std::path::Path;

use fdiag::{model::file::read_settings, spec::PipelineSpec};
use serde::de::DeserializeOwned;

use crate::failure::Failure;

/// Reads a file of settings; the message of a wrong one names its line and key.
///
/// # Errors
///
/// A file that is missing or wrong.
pub fn read<T: DeserializeOwned>(file: &Path) -> Result<T, Failure> {
    read_settings(file).map_err(Failure::of_input)
}

/// Reads a spec; the path of a model file in it begins where the spec is.
///
/// # Errors
///
/// A file that is missing or wrong.
pub fn read_spec(file: &Path) -> Result<PipelineSpec, Failure> {
    let mut spec: PipelineSpec = read(file)?;
    spec.generator.begin_in(file.parent().unwrap_or(Path::new("")));
    Ok(spec)
}
