//! What an entry is made of: a residual generator, a bias model, a detector.

use fdiag::spec::{BiasSpec, DetectorSpec, GeneratorSpec, ModelSource};
use serde::{Deserialize, Serialize};

/// A named residual generator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Generator {
    /// A short name.
    pub name: String,
    /// The generator.
    pub spec: GeneratorSpec,
    /// Rows of the weighting on its residual.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weighting: Option<Vec<Vec<f64>>>,
    /// Of a simulation of the engine whose model stands in the configuration: time in s from the beginning of the
    /// training run that is diagnosed first, on every engine. What runs is the model with the named causes in it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub diagnose_s: Option<f64>,
}

/// A named bias model, or none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bias {
    /// A short name.
    pub name: String,
    /// The bias model; without it nothing is subtracted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spec: Option<BiasSpec>,
}

/// A named detector.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Detector {
    /// A short name.
    pub name: String,
    /// The detector. The rate of false alarms in it plays no part: that of the comparison counts.
    pub spec: DetectorSpec,
}

/// Whether a diagnosis can complete the model of a generator.
pub(super) fn is_diagnosed(spec: &GeneratorSpec) -> bool {
    matches!(spec, GeneratorSpec::Patched { model: ModelSource::Text { .. }, .. })
}
