//! Noise of the sensors of the engine.

use fd_jetengine::engine17::{Engine17, NY, Parameters};

use super::{EngineKnowledge, EnginePlantError};

/// Standard deviation of the noise of `N_L, N_H, T_7, P_6, T_29`, relative to the reading at the
/// start.
pub const RELATIVE_NOISE: [f64; NY] = [5e-4, 5e-4, 1e-3, 1e-3, 1e-3];
/// Standard deviation of the noise of each output, in its unit.
///
/// # Errors
///
/// Returns an error when the engine cannot be trimmed.
pub fn engine_noise(known: &EngineKnowledge) -> Result<Vec<Option<f64>>, EnginePlantError> {
    let outputs = Engine17::new(&Parameters::default())?.trim(known.fuel)?.outputs();
    Ok(outputs.iter().zip(RELATIVE_NOISE).map(|(y, noise)| Some(y * noise)).collect())
}
