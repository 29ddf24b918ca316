//! The JSON schemas of `docs/`, written by the tests that compare them with their types.

use std::{path::Path, process::Command};

use crate::sources::Faults;

/// Runs those tests such that they write.
pub(crate) fn write(root: &Path) -> Faults {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let status = Command::new(cargo)
        .args(["test", "--quiet", "--package", "fdiag-cli", "--test", "suite"])
        .arg("the_schema_is_that_of_the_types")
        .env("FDIAG_WRITE_SCHEMA", "1")
        .current_dir(root)
        .status()
        .map_err(|e| format!("cargo test: {e}"))?;
    if status.success() { Ok(Vec::new()) } else { Err("the schema was not written".to_owned()) }
}
