//! Why a generator of a spec cannot be made.

use fd_data::DataError;
use fd_nonlinear::NonlinearError;
use fd_residual::DesignError;
use fd_sim::model::LoadError;
use thiserror::Error;

use crate::engine_plant::{EngineFileError, EnginePlantError};

/// A residual generator cannot be made from what its line of the spec says.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum GeneratorSpecError {
    /// The linear model does not allow it.
    #[error(transparent)]
    Design(#[from] DesignError),
    /// The nonlinear model does not allow it, or a setting makes no sense.
    #[error(transparent)]
    Nonlinear(#[from] NonlinearError),
    /// The healthy logs do not allow it, or a setting makes no sense.
    #[error("generator: {0}")]
    Data(#[from] DataError),
    /// The model file cannot be read.
    #[error(transparent)]
    Model(#[from] LoadError),
    /// The model file of the engine is wrong.
    #[error(transparent)]
    EngineFile(#[from] EngineFileError),
    /// There is no engine as its file says.
    #[error(transparent)]
    Engine(Box<EnginePlantError>),
    /// A kind of model file that has no state equations.
    #[error("{file}: this is a model of kind `{found}`, expected {expected}")]
    ModelKind {
        /// The file.
        file: String,
        /// Kinds that will do.
        expected: &'static str,
        /// Kind of the file.
        found: String,
    },
    /// An engine with effects in a shell around it.
    #[error(
        "an engine with `equations` around it has no state equations: take `kind = \"patched\"`"
    )]
    NoEquations,
    /// The model has other channels than the pipeline.
    #[error("generator.model: expected the {signal}s {expected}, found {found}")]
    Channels {
        /// `"input"` or `"output"`.
        signal: &'static str,
        /// Channels of the pipeline.
        expected: String,
        /// Channels of the model.
        found: String,
    },
    /// A table of the spec names something that the model does not have.
    #[error("generator.{table}: expected names out of {known}, found `{found}`")]
    Unknown {
        /// The table.
        table: &'static str,
        /// What there is.
        known: String,
        /// The name.
        found: String,
    },
    /// A number by channel is needed, and neither the spec nor the model file says it.
    #[error(
        "generator.{table}: expected a number for `{channel}`, found none, nor in the model file"
    )]
    Missing {
        /// The table.
        table: &'static str,
        /// The channel.
        channel: String,
    },
    /// A relative number for a channel that has no size.
    #[error(
        "generator.{table}: expected a number for `{channel}` by name: its initial value of 0 gives a \
         relative one no meaning"
    )]
    NoSize {
        /// The table.
        table: &'static str,
        /// The channel.
        channel: String,
    },
    /// A simulation that would have to know the inputs of the next sample.
    #[error(
        "generator.model: expected `hold = \"zero\"`, found \"linear\": the next inputs are not yet known"
    )]
    Hold,
}
