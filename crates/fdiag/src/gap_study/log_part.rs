//! Parts of logs: where they come from and what they are used for.

use std::path::{Path, PathBuf};

use fd_model::{Record, TimeBaseReport};
use schemars::JsonSchema;
use serde::Serialize;

/// A run, or a part of one.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct LogPart {
    /// Name of the file, without its directory.
    pub file: String,
    /// Where the file is; not serialised.
    #[serde(skip)]
    pub path: PathBuf,
    /// What it is used for.
    pub role: Role,
    /// First sample of the file's grid, and one after the last.
    pub samples: [usize; 2],
    /// Share of the output values in this part that are missing, 0 to 1.
    pub missing_share: f64,
    /// What the times of the whole file were like.
    pub time_base: TimeBaseReport,
}

/// What a log is used for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Role {
    /// Models are fitted to it.
    Fit,
    /// No fit sees it.
    HeldOut,
}

/// Where the time between samples comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Pace {
    /// The user has stated it.
    Stated,
    /// The model itself is sampled, or its controller is.
    Model,
    /// The first log.
    FirstLog,
}

impl LogPart {
    /// A part of a file: `record` has its samples, `time_base` is that of the file.
    pub(super) fn new(
        path: &Path,
        role: Role,
        samples: [usize; 2],
        record: &Record,
        time_base: &TimeBaseReport,
    ) -> Self {
        Self {
            file: file_name(path),
            path: path.to_owned(),
            role,
            samples,
            missing_share: missing(record),
            time_base: time_base.clone(),
        }
    }

    /// Samples in this part.
    #[must_use]
    pub fn len(&self) -> usize {
        self.samples[1] - self.samples[0]
    }

    /// Whether it has no sample.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// The last part of a path, which is what people call a file.
pub(super) fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

fn missing(record: &Record) -> f64 {
    let values = (0..record.outputs().len()).flat_map(|c| record.output(c));
    let (missing, all) =
        values.fold((0.0, 0.0), |(m, n), v| (m + f64::from(u8::from(!v.is_finite())), n + 1.0));
    missing / f64::max(all, 1.0)
}
