//! Why a model has no structure.

use thiserror::Error;

use crate::model::StructureError;

/// No structural model can be made.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum EquationsError {
    /// A fault is wanted at something that has no equation.
    #[error(
        "no fault can be placed at `{name}`: expected sensors, actuators, laws, definitions, all, none, or one of {known}"
    )]
    NoPlace {
        /// What was asked for.
        name: String,
        /// Inputs, states, definitions and outputs.
        known: String,
    },
    /// The structure is inconsistent.
    #[error(transparent)]
    Structure(#[from] StructureError),
}
