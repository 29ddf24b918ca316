//! Slow noise whose size is not stated.
//!
//! Differences of neighbouring samples show how strong white noise is. They show almost nothing of slow noise:
//! a road under a car, wind on a yaw rate, a process that wanders. Slow noise differs from a gap in that
//! nothing known predicts it: neither past inputs nor the simulation. The residual of a missing effect nearly
//! always follows these.
//!
//! *When not to use:* where the model states the noise, because its size then shows what is too much; and on a
//! coarse grid, whose rounding errors are not filtered noise.

use super::known::{Known, signals};
use crate::{
    diagnose::{prepare::noise::KnownNoise, search::searched::Searched},
    evidence::grades::STRONG,
    fit::FitError,
    quality::pattern,
};

/// The noise, with what is known after the best explanation of a search has `left` errors (in sigma): for which
/// outputs they are noise of any size and colour.
pub(in crate::diagnose) fn with_slow(
    searched: &Searched<'_>,
    left: &[Vec<Vec<f64>>],
) -> Result<KnownNoise, FitError> {
    let mut noise = searched.noise.clone();
    let may_be: Vec<bool> =
        (0..left.len()).map(|c| noise.stated[c].is_none() && !noise.is_coarse(c)).collect();
    if !may_be.contains(&true) {
        return Ok(noise);
    }
    let mut problem = searched.null.problem.clone();
    let outputs = problem.outputs(&searched.null.minimum.z).ok_or(FitError::Diverged)?;
    let inputs = searched.model.external_inputs().len();
    let signals = signals(Known { problem: &problem, inputs, outputs: &outputs });
    for ((is_slow, errors), may_be) in noise.slow.iter_mut().zip(left).zip(may_be) {
        *is_slow |= may_be && pattern(errors, &signals) < STRONG;
    }
    Ok(noise)
}
