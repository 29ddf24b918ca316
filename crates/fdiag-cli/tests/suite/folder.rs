//! A folder of its own with files of the examples in it.

#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use std::{
    fs,
    path::{Path, PathBuf},
};

use tempfile::TempDir;

/// A folder that goes with the value.
pub(crate) struct Folder(TempDir);

impl Folder {
    /// With these files of `examples/` under these names.
    pub(crate) fn of(examples: &[(&str, &str)]) -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
        for (from, to) in examples {
            fs::copy(root.join(from), folder.path(to)).unwrap();
        }
        folder
    }

    /// With the model and a log of the quick start, and of the turbine.
    pub(crate) fn of_both() -> Self {
        Self::of(&[
            ("gap/quick-start/model.toml", "model.toml"),
            ("gap/quick-start/monday.csv", "monday.csv"),
            ("turbine.toml", "turbine.toml"),
            ("turbine-run.csv", "run.csv"),
        ])
    }

    pub(crate) fn root(&self) -> &Path {
        self.0.path()
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.root().join(name)
    }
}
