//! Whose state it is.

use fd_model::{SampleTime, file::LinearModel};
use fdiag::spec::PipelineSpec;
use serde::{Deserialize, Serialize};

use super::sealed::Sum;
use crate::learning::Learning;

/// What a state belongs to. A state of anything else is refused: its numbers would mean something else.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Identity {
    /// Version of the program.
    pub version: String,
    /// Sum over the model.
    pub model: String,
    /// Sum over the spec.
    pub spec: String,
    /// Sum over the healthy logs, or how long each unit learns, and over sample time and longest gap.
    pub samples: String,
}

impl Identity {
    pub(crate) fn of(
        model: &LinearModel,
        spec: &PipelineSpec,
        learning: &Learning,
        share: f64,
        step: SampleTime,
        gap: f64,
    ) -> Self {
        let mut samples = Sum::default();
        for number in [share, step.seconds(), gap] {
            samples.add(&number.to_bits().to_le_bytes());
        }
        match learning {
            Learning::Stream { samples: count } => samples.add(&count.to_le_bytes()),
            Learning::Logs(logs) => {
                for log in logs {
                    samples.add(&log.len().to_le_bytes());
                    for value in log.samples().flat_map(|(u, y)| u.iter().chain(y)) {
                        samples.add(&value.to_bits().to_le_bytes());
                    }
                }
            }
        }
        let of = |text: &str| {
            let mut sum = Sum::default();
            sum.add(text.as_bytes());
            sum.to_string()
        };
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            model: of(&model.to_toml()),
            // Every spec can be written as TOML: it is what users write.
            spec: of(&spec.to_toml().unwrap_or_default()),
            samples: samples.to_string(),
        }
    }

    /// The first thing that differs: what, what is expected, and what was found.
    pub(super) fn differs<'a>(
        &'a self,
        found: &'a Self,
    ) -> Option<(&'static str, &'a str, &'a str)> {
        let pairs = [
            ("version", &self.version, &found.version),
            ("model", &self.model, &found.model),
            ("spec", &self.spec, &found.spec),
            ("healthy samples or sample time", &self.samples, &found.samples),
        ];
        let mut different = pairs.into_iter().filter(|(_, expected, found)| expected != found);
        different.next().map(|(what, expected, found)| (what, expected.as_str(), found.as_str()))
    }
}
