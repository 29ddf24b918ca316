//! What can stop the engine benchmark.

use fd_core::LimitError;
use fd_jetengine::EngineError;
use fd_model::{ModelError, RecordError, SimulationError, file::ModelFileError};
use fdiag::training::TrainingError;
use thiserror::Error;

/// The benchmark cannot be set up or run.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum EngineStudyError {
    /// The configuration is of another version.
    #[error("configuration has version {found}, this program reads version {expected}")]
    Version {
        /// Version that can be read.
        expected: u32,
        /// Version that was found.
        found: u32,
    },
    /// A setting is out of its range.
    #[error("{setting} must be finite and not negative, got {found}")]
    Setting {
        /// Name of the setting.
        setting: &'static str,
        /// Value that was given.
        found: f64,
    },
    /// A count must be at least one.
    #[error("{setting} must be at least 1, got 0")]
    None {
        /// Name of the setting.
        setting: &'static str,
    },
    /// A setting is beyond a limit.
    #[error(transparent)]
    Limit(#[from] LimitError),
    /// There is no such sensor.
    #[error("faults.sensors: there is no output `{found}`; the outputs are {}", known.join(", "))]
    UnknownSensor {
        /// Name that was given.
        found: String,
        /// Names of the outputs.
        known: Vec<String>,
    },
    /// An output is not a state, so the model cannot be reduced to the measured states.
    #[error(
        "reduction `measured-states`: output {output} (counted from 0) is not a single state; \
         use a balanced reduction"
    )]
    NotAState {
        /// Index of the output.
        output: usize,
    },
    /// The engine.
    #[error("engine: {0}")]
    Engine(#[from] EngineError),
    /// A linear model.
    #[error("model: {0}")]
    Model(#[from] ModelError),
    /// A run of the engine.
    #[error("engine run: {0}")]
    Simulation(#[from] SimulationError),
    /// A model file for users.
    #[error(transparent)]
    ModelFile(#[from] ModelFileError),
    /// A log for users.
    #[error("log: {0}")]
    Record(#[from] RecordError),
    /// Training or diagnosis.
    #[error(transparent)]
    Training(#[from] TrainingError),
    /// One of many seeds.
    #[error("seed {seed}: {error}")]
    Seed {
        /// The seed.
        seed: u64,
        /// What went wrong.
        error: Box<EngineStudyError>,
    },
}
