//! What the model files of a comparison held, so that one that was begun is not continued with others.

use std::{
    fs,
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::{config::CompareConfig, error::CompareError};
use crate::hex::to_hex;

/// A model file and the SHA-256 of its contents, in hexadecimal digits.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct FileHash {
    file: PathBuf,
    sha256: String,
}

/// Those of all model files that a configuration names, in the order of their paths.
pub(super) fn file_hashes(config: &CompareConfig) -> Result<Vec<FileHash>, CompareError> {
    config.model_files().into_iter().map(hash).collect()
}

fn hash(file: &Path) -> Result<FileHash, CompareError> {
    let bytes =
        fs::read(file).map_err(|source| CompareError::File { file: file.to_owned(), source })?;
    let sha256 = to_hex(&Sha256::digest(bytes));
    Ok(FileHash { file: file.to_owned(), sha256 })
}

/// The first file that is now another one than it was. Both lists are of the same configuration.
pub(super) fn first_changed(then: &[FileHash], now: &[FileHash]) -> Option<PathBuf> {
    now.iter().find(|file| !then.contains(file)).map(|changed| changed.file.clone())
}
