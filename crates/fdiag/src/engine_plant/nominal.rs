//! The engine as what a diagnosis takes: a model that effects can be spliced into.

use fd_sim::simulate::{Nominal, Shell};

use super::{EngineKnowledge, EnginePlantError, EngineSimulator, engine_noise, linear_engine};

/// The nonlinear engine, as the black box that it is to a diagnosis.
///
/// # Errors
///
/// Returns an error when the engine cannot be trimmed.
pub fn nonlinear_engine(known: &EngineKnowledge) -> Result<Shell, EnginePlantError> {
    let engine = Box::new(EngineSimulator::new(known)?);
    Ok(Shell::new("engine17", engine)?.with_noise(&engine_noise(known)?))
}

/// The linear or the nonlinear simulator.
///
/// # Errors
///
/// Returns an error when the engine cannot be trimmed.
pub fn simulator(
    known: &EngineKnowledge,
    is_linear: bool,
) -> Result<Box<dyn Nominal>, EnginePlantError> {
    Ok(if is_linear {
        Box::new(linear_engine(known, &engine_noise(known)?)?)
    } else {
        Box::new(nonlinear_engine(known)?)
    })
}
