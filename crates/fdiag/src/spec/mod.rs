//! A pipeline described as data: one TOML file chooses every stage.
//!
//! Each table has a `kind`; an unknown kind or setting is refused with the list of known ones. A spec can only
//! name built-in methods. A method of your own goes directly into [`Stages`](fd_core::Stages), boxed or not.

mod adaptive;
mod bias;
mod detector;
mod detector_data;
mod generator;
mod isolation;
mod limits;
mod place;
mod plant;
mod signature;
mod start;
#[cfg(feature = "testing")]
pub mod testing;

use std::{path::Path, str::FromStr};

use fd_compensate::{
    calibrate::CalibrationPlan,
    decide::{Debouncing, Sizing},
    residual_compensation::CompensationPlan,
};
use fd_model::file::{SettingsError, read_settings, write_settings};
use serde::{Deserialize, Serialize};

pub use self::{
    adaptive::{AdaptiveSpec, BoundSpec},
    bias::{ApplySpec, BiasSpec, LearningSpec, OrderSpec, StructureSpec},
    detector::DetectorSpec,
    detector_data::{DetectorData, DetectorSpecError},
    generator::{
        ComponentSpec, DeviationSpec, DisturbanceSpec, FaultEntry, GeneratorSpec,
        GeneratorSpecError, ModelBoundSpec, ModelSource, ParameterSpec, PartSpec, ShiftSpec,
        SignatureSpec, ZonotopeSpec,
    },
    isolation::{IsolationSpec, IsolationSpecError},
    limits::check_limits,
    place::FaultPlace,
    plant::NominalPlant,
    signature::FaultSites,
    start::StartSpec,
};

/// Every choice of a diagnosis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PipelineSpec {
    /// Samples to primary residuals.
    pub generator: GeneratorSpec,
    /// Rows of the weighting `W` on the residual; none leaves it as it is. The paper's choice for
    /// five outputs is `[[1, 1, 1, 1, 1]]`, which makes the residual a scalar.
    pub weighting: Option<Vec<Vec<f64>>>,
    /// The bias model and how it is learned.
    pub bias: BiasSpec,
    /// Whether a running diagnosis begins with the fitted bias or learns it on line first.
    pub start: StartSpec,
    /// When training ends, and what guards the compensation.
    pub compensation: CompensationPlan,
    /// Compensated residuals to test statistics.
    pub detector: DetectorSpec,
    /// How a threshold is found for a stated rate of false alarms; its debouncing is that of
    /// `rule`.
    pub calibration: CalibrationPlan,
    /// Test statistics to alarms.
    pub rule: Debouncing,
    /// What is said of a fault beyond that there is one.
    pub isolation: IsolationSpec,
    /// How the size of a fault is estimated after an alarm, but for probable faults.
    pub sizing: Sizing,
    /// Time in s at the start of each log that is not learned from, while the generator forgets
    /// where it started; none takes five time constants of its slowest pole.
    pub settle_s: Option<f64>,
    /// Most missing samples in a row that are replaced by the last good one; 0 refuses them.
    pub hold_missing: u64,
}

impl PipelineSpec {
    /// Reads a spec from a file; the path of a model file in it begins where the spec is.
    ///
    /// # Errors
    ///
    /// As [`read_settings`].
    pub fn read(file: &Path) -> Result<Self, SettingsError> {
        let mut spec: Self = read_settings(file)?;
        spec.generator.begin_in(file.parent().unwrap_or(Path::new("")));
        Ok(spec)
    }

    /// The spec as TOML, compiled once: `toml::to_string` is compiled again wherever it is used.
    ///
    /// # Errors
    ///
    /// None for a spec that was read.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        write_settings(self)
    }
}

impl FromStr for PipelineSpec {
    type Err = toml::de::Error;

    /// From TOML, compiled once: `toml::from_str` is compiled again wherever it is used.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        toml::from_str(text)
    }
}

impl Default for PipelineSpec {
    fn default() -> Self {
        Self {
            generator: GeneratorSpec::Simulation {},
            weighting: None,
            bias: BiasSpec::default(),
            start: StartSpec::default(),
            compensation: CompensationPlan::default(),
            detector: DetectorSpec::default(),
            calibration: CalibrationPlan::default(),
            rule: Debouncing::consecutive(3),
            isolation: IsolationSpec::default(),
            sizing: Sizing::default(),
            settle_s: None,
            hold_missing: 0,
        }
    }
}
