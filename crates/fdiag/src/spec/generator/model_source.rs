//! Where the nonlinear model of a generator comes from.

use std::path::{Path, PathBuf};

use fd_core::Limits;
use fd_jetengine::engine17::input_channels;
use fd_model::{Channel, SampleTime, file::read_text};
use fd_nonlinear::{PlantEquations, StateEquations};
use fd_sim::{
    model::{LoadError, Model},
    simulate::{Initial, Nominal, StateMap},
};
use serde::{Deserialize, Serialize};

use super::error::GeneratorSpecError;
use crate::engine_plant::{ENGINE_KIND, EngineEquations, EngineFile};

/// A model file, by its path or in the spec itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum ModelSource {
    /// The path of the file; a relative one begins where the spec is, or else where the program runs.
    File(PathBuf),
    /// What would stand in the file.
    Text {
        /// TOML, such as `version = 1`, `kind = "equations"`, …
        text: String,
    },
}

/// What was read.
pub(super) enum NonlinearFile {
    Equations(Box<Model>),
    Engine(Box<EngineFile>),
}

/// State equations with the names of everything in them.
pub(super) struct NamedEquations {
    pub equations: Box<dyn StateEquations>,
    pub states: Vec<Initial>,
    pub inputs: Vec<Channel>,
    pub outputs: Vec<Channel>,
    /// Standard deviations of the noise of the outputs that the file states.
    pub noise: Vec<Option<f64>>,
}

impl ModelSource {
    /// The equations of the file.
    ///
    /// # Errors
    ///
    /// Returns an error when the file cannot be read or holds no equations.
    pub fn equations(&self) -> Result<Model, GeneratorSpecError> {
        match self.read()? {
            NonlinearFile::Equations(model) => Ok(*model),
            NonlinearFile::Engine(_) => {
                let (file, found) = (self.name(), ENGINE_KIND.to_owned());
                Err(GeneratorSpecError::ModelKind { file, expected: "`equations`", found })
            }
        }
    }

    /// A relative path made to begin in `folder`.
    pub fn begin_in(&mut self, folder: &Path) {
        if let Self::File(path) = self
            && path.is_relative()
        {
            *path = folder.join(&*path);
        }
    }

    /// The file, unless the text stands in the spec.
    #[must_use]
    pub fn file(&self) -> Option<&Path> {
        match self {
            Self::File(path) => Some(path),
            Self::Text { .. } => None,
        }
    }

    fn name(&self) -> String {
        match self {
            Self::File(path) => path.display().to_string(),
            Self::Text { .. } => "generator.model".to_owned(),
        }
    }

    pub(super) fn read(&self) -> Result<NonlinearFile, GeneratorSpecError> {
        let file = self.name();
        let text = match self {
            Self::Text { text } => text.clone(),
            Self::File(path) => read_text(path, Limits::default().bytes).map_err(|error| {
                LoadError::Read { file: file.clone(), message: error.to_string() }
            })?,
        };
        // What is no TOML at all is an error of the reader of equations, which says where.
        let table = text.parse::<toml::Table>().ok();
        let kind = table.as_ref().and_then(|table| table.get("kind")).and_then(toml::Value::as_str);
        Ok(match kind {
            Some("equations") | None => {
                let model = text.parse().map_err(|error| LoadError::Model { file, error })?;
                NonlinearFile::Equations(Box::new(model))
            }
            Some(ENGINE_KIND) => NonlinearFile::Engine(Box::new(EngineFile::parse(&file, &text)?)),
            Some(found) => {
                let (expected, found) = ("`equations` or `engine17`", found.to_owned());
                return Err(GeneratorSpecError::ModelKind { file, expected, found });
            }
        })
    }
}

impl NonlinearFile {
    /// The state equations for samples so far apart.
    pub(super) fn equations(&self, ts: SampleTime) -> Result<NamedEquations, GeneratorSpecError> {
        match self {
            Self::Equations(model) => {
                let map = StateMap::new(model, &model.nominal(), ts).map_err(wrapped)?;
                Ok(NamedEquations {
                    states: map.states().to_vec(),
                    inputs: map.inputs().to_vec(),
                    outputs: map.outputs().to_vec(),
                    noise: model.outputs.iter().map(|output| output.noise).collect(),
                    equations: Box::new(map),
                })
            }
            Self::Engine(file) => {
                let known = file.known(ts).map_err(engine_error)?;
                if file.is_changed() {
                    return Err(GeneratorSpecError::NoEquations);
                }
                let (plant, states) =
                    EngineEquations::new(&known).map_err(|error| engine_error(error.into()))?;
                Ok(NamedEquations {
                    equations: Box::new(PlantEquations::new(plant)),
                    states,
                    inputs: input_channels(),
                    outputs: file.outputs(),
                    noise: file.noise_of_outputs(),
                })
            }
        }
    }

    /// What is simulated, with whatever was spliced into it.
    pub(super) fn nominal(&self, ts: SampleTime) -> Result<Box<dyn Nominal>, GeneratorSpecError> {
        match self {
            Self::Equations(model) => Ok(model.clone()),
            Self::Engine(file) => file.nominal(ts).map_err(engine_error),
        }
    }
}

fn wrapped(error: fd_sim::simulate::SimulateError) -> GeneratorSpecError {
    GeneratorSpecError::Nonlinear(error.into())
}

fn engine_error(error: crate::engine_plant::EnginePlantError) -> GeneratorSpecError {
    GeneratorSpecError::Engine(Box::new(error))
}
