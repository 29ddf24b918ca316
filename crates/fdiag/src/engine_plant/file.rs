//! The jet engine as a model file: `kind = "engine17"`.

use std::{collections::BTreeMap, path::Path};

use fd_jetengine::engine17::{input_channels, output_channels};
use fd_model::{Channel, SampleTime, file::write_settings};
use fd_sim::{
    model::Model,
    simulate::{Nominal, Shell},
};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{EngineKnowledge, EnginePlantError, EngineSimulator, linear_engine};

/// Value of `kind` in such a file.
pub const ENGINE_KIND: &str = "engine17";
/// Format version that this program reads and writes.
const VERSION: u32 = 1;
/// Longest integration step, in s: Runge-Kutta of order 4 is stable at the reference point up to
/// 8 ms.
const LONGEST_STEP: f64 = 8e-3;

/// A model file of the jet engine: which simulator, where logs begin, what is measured and known.
///
/// ```
/// use fd_model::SampleTime;
/// use fdiag::engine_plant::EngineFile;
///
/// let file = EngineFile::parse("engine.toml", r#"
/// version = 1
/// kind = "engine17"
/// simulator = "linear"
/// outputs = ["N_L", "T_7"]
/// noise = { N_L = 3.6, T_7 = 0.7 }
/// "#)?;
/// let engine = file.nominal(SampleTime::new(0.04)?)?;
/// assert_eq!(engine.model().outputs[1].name, "T_7");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EngineFile {
    version: u32,
    kind: String,
    /// The nonlinear engine or its linearisation.
    #[serde(default)]
    simulator: Kind,
    /// Fuel flow in kg/s at which the engine has settled when a log begins.
    #[serde(default = "reference_fuel")]
    fuel_flow: f64,
    /// Longest integration step of the nonlinear engine, in s.
    #[serde(default = "default_step")]
    step: f64,
    /// Time between samples, in s; none means that of the first log.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    sample_time: Option<f64>,
    /// What is measured.
    #[serde(default = "all_outputs")]
    outputs: Vec<String>,
    /// Equations around the nonlinear engine, as a diagnosis writes them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    equations: Option<String>,
    #[serde(default)]
    tolerances: Tolerances,
    /// Standard deviations of the noise of outputs, in their units.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    noise: BTreeMap<String, f64>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Kind {
    #[default]
    Nonlinear,
    Linear,
}

/// How well the engine is known, as fractions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Tolerances {
    /// Efficiencies and flow capacities of the modules.
    modules: f64,
    /// Heating value of the fuel.
    heating_value: f64,
}

impl Default for Tolerances {
    fn default() -> Self {
        Self { modules: 2e-3, heating_value: 5e-3 }
    }
}

/// A model file of the engine is wrong.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum EngineFileError {
    /// It is no TOML, or has wrong, unknown or missing keys.
    #[error("{file}: {message}")]
    Syntax {
        /// The file.
        file: String,
        /// What is wrong and where.
        message: String,
    },
    /// A value makes no sense.
    #[error("{file}: {key}: expected {expected}, found `{found}`")]
    Value {
        /// The file.
        file: String,
        /// Key of the value.
        key: &'static str,
        /// What would make sense.
        expected: &'static str,
        /// The value.
        found: String,
    },
    /// There is no engine as the file says.
    #[error("{file}: {source}")]
    Engine {
        /// The file.
        file: String,
        /// Why there is none.
        source: Box<EnginePlantError>,
    },
}

fn reference_fuel() -> f64 {
    0.712
}

fn default_step() -> f64 {
    5e-3
}

fn all_outputs() -> Vec<String> {
    output_channels().into_iter().map(|channel| channel.name).collect()
}

impl EngineFile {
    /// Reads the text of a file, of which the name is for messages.
    ///
    /// # Errors
    ///
    /// Returns the first key that is wrong.
    pub fn parse(file: &str, text: &str) -> Result<Self, EngineFileError> {
        let read: Self = toml::from_str(text).map_err(|error| EngineFileError::Syntax {
            file: file.to_owned(),
            message: error.to_string(),
        })?;
        match read.wrong() {
            None => Ok(read),
            Some((key, expected, found)) => {
                Err(EngineFileError::Value { file: file.to_owned(), key, expected, found })
            }
        }
    }

    /// The first value that makes no sense: its key, what would, and what it is.
    fn wrong(&self) -> Option<(&'static str, &'static str, String)> {
        const OUTPUT: &str = "names out of `N_L`, `N_H`, `T_7`, `P_6`, `T_29`, each once";
        let all = all_outputs();
        let is_output = |name: &String| all.contains(name);
        let is_once = |(i, name): (usize, &String)| !self.outputs[..i].contains(name);
        let is_share = |share: f64| (0.0..1.0).contains(&share);
        let is_positive = |value: f64| 0.0 < value && value.is_finite();
        let is_linear = self.simulator == Kind::Linear;
        let Tolerances { modules, heating_value } = self.tolerances;
        let noise = self.noise.iter().find(|(_, sigma)| !is_positive(**sigma));
        let checks = [
            (self.version == VERSION, "version", "1", self.version.to_string()),
            (self.kind == ENGINE_KIND, "kind", "`engine17`", self.kind.clone()),
            (is_positive(self.fuel_flow), "fuel_flow", "kg/s above 0", self.fuel_flow.to_string()),
            (
                is_positive(self.step) && self.step <= LONGEST_STEP,
                "step",
                "seconds above 0 and up to 0.008, where the integration is stable",
                self.step.to_string(),
            ),
            (
                self.sample_time.is_none_or(is_positive),
                "sample_time",
                "seconds above 0",
                self.sample_time.unwrap_or_default().to_string(),
            ),
            (
                !self.outputs.is_empty()
                    && self.outputs.iter().all(is_output)
                    && self.outputs.iter().enumerate().all(is_once),
                "outputs",
                OUTPUT,
                self.outputs.join("`, `"),
            ),
            (
                is_share(modules) && is_share(heating_value),
                "tolerances",
                "fractions from 0 on and below 1",
                format!("{modules}, {heating_value}"),
            ),
            (
                self.noise.keys().all(is_output),
                "noise",
                OUTPUT,
                self.noise.keys().cloned().collect::<Vec<_>>().join("`, `"),
            ),
            (
                noise.is_none(),
                "noise",
                "standard deviations above 0",
                noise.map_or_else(String::new, |(name, sigma)| format!("{name} = {sigma}")),
            ),
            (
                !(is_linear && self.equations.is_some()),
                "equations",
                "none, for the linear engine is equations",
                "some".to_owned(),
            ),
        ];
        let wrong = checks.into_iter().find(|(is_right, ..)| !is_right);
        wrong.map(|(_, key, expected, found)| (key, expected, found))
    }

    /// Channel of the input.
    #[must_use]
    pub fn inputs(&self) -> Vec<Channel> {
        input_channels()
    }

    /// Channels of what is measured.
    #[must_use]
    pub fn outputs(&self) -> Vec<Channel> {
        let all = output_channels();
        let find = |name: &String| all.iter().find(|channel| channel.name == *name).cloned();
        self.outputs.iter().filter_map(find).collect()
    }

    /// Time between samples, in s, if the file says it.
    #[must_use]
    pub fn sample_time(&self) -> Option<f64> {
        self.sample_time
    }

    /// The simulator, for samples so far apart unless the file says how far.
    ///
    /// # Errors
    ///
    /// Returns an error when the engine does not run at the fuel flow, or the equations are not
    /// those of a shell around it.
    pub fn nominal(&self, ts: SampleTime) -> Result<Box<dyn Nominal>, EnginePlantError> {
        let known = self.known(ts)?;
        let noise = self.noise_of_outputs();
        if self.simulator == Kind::Linear {
            return Ok(Box::new(linear_engine(&known, &noise)?));
        }
        let shell = Self::shell(&known)?;
        Ok(Box::new(match &self.equations {
            None => shell.with_noise(&noise),
            Some(text) => shell.with_model(text.parse::<Model>()?)?,
        }))
    }

    /// Standard deviations of the noise of what is measured, where the file states them.
    #[must_use]
    pub fn noise_of_outputs(&self) -> Vec<Option<f64>> {
        self.outputs.iter().map(|name| self.noise.get(name).copied()).collect()
    }

    /// Whether there are equations around the engine, or it is not the nonlinear one.
    pub(crate) fn is_changed(&self) -> bool {
        self.equations.is_some() || self.simulator == Kind::Linear
    }

    /// The simulator with another model: that of its own with other tolerances or noise.
    ///
    /// # Errors
    ///
    /// Returns an error when the engine cannot be trimmed, or the model does not fit it.
    pub fn nominal_as(
        &self,
        ts: SampleTime,
        model: Model,
    ) -> Result<Box<dyn Nominal>, EnginePlantError> {
        Ok(match self.simulator {
            Kind::Linear => Box::new(model),
            Kind::Nonlinear => Box::new(Self::shell(&self.known(ts)?)?.with_model(model)?),
        })
    }

    fn shell(known: &EngineKnowledge) -> Result<Shell, EnginePlantError> {
        Ok(Shell::new(ENGINE_KIND, Box::new(EngineSimulator::new(known)?))?)
    }

    /// What the file says of the engine, for samples so far apart unless it says how far.
    ///
    /// # Errors
    ///
    /// Returns an error when the sample time cannot be.
    pub fn known(&self, ts: SampleTime) -> Result<EngineKnowledge, EnginePlantError> {
        let all = all_outputs();
        let place = |name: &String| all.iter().position(|known| known == name);
        let ts = self.sample_time.map_or(Ok(ts), SampleTime::new)?;
        Ok(EngineKnowledge {
            step: self.step,
            module_tolerance: self.tolerances.modules,
            fuel_tolerance: self.tolerances.heating_value,
            outputs: self.outputs.iter().filter_map(place).collect(),
            ..EngineKnowledge::at(self.fuel_flow, ts)
        })
    }

    /// The text of a file of this engine with other equations around it. The linear engine is
    /// equations and nothing else.
    #[must_use]
    pub fn text(&self, model: &Model) -> String {
        if self.simulator == Kind::Linear {
            return model.to_string();
        }
        let noise = model.outputs.iter().filter_map(|o| Some((o.name.clone(), o.noise?)));
        let file = Self {
            sample_time: Some(model.sample_time),
            equations: Some(format!("\n{model}")),
            noise: noise.collect(),
            ..self.clone()
        };
        // Numbers, names and text: nothing that TOML does not have.
        write_settings(&file).unwrap_or_default()
    }

    /// What went wrong with the engine of a file.
    #[must_use]
    pub fn error(path: &Path, error: EnginePlantError) -> EngineFileError {
        EngineFileError::Engine { file: path.display().to_string(), source: Box::new(error) }
    }
}
