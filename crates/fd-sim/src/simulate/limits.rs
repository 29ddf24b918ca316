//! Limits on the cost of a simulation, checked before anything of that size is allocated.

use fd_core::{Limits, Resource};
use fd_model::SampleTime;

use super::{error::SimulateError, flat::flatten, timing::Timing};
use crate::model::Model;

/// Compares the integration steps per sample and the lengths of the delays of a model with limits.
///
/// Simulators compare themselves with [`Limits::default`]; this is for whoever sets lower ones.
///
/// ```
/// use fd_core::Limits;
/// use fd_sim::{model::Model, simulate::check_limits};
///
/// let model: Model = r#"
/// version = 1
/// kind = "equations"
/// name = "line"
/// sample_time = 0.01
/// step = 0.001
/// inputs = { u = { unit = "1" } }
/// outputs = { y = { unit = "1", value = "late" } }
/// delays = { late = { value = "u", time = "0.5" } }
/// "#.parse()?;
/// let limits = Limits { delay_steps: 400, ..Limits::default() };
/// let refused = check_limits(&model, model.sample_time()?, &limits).map_err(|e| e.to_string());
/// let words = "delay `late` of 0.5 s: expected at most 400 integration steps (limit `delay_steps`), found 500";
/// assert_eq!(refused, Err(words.to_owned()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// Returns the limit that is exceeded, or why the model cannot be simulated at all.
pub fn check_limits(model: &Model, ts: SampleTime, limits: &Limits) -> Result<(), SimulateError> {
    let timing = Timing::choose(model, &flatten(model, &[]), ts, limits)?;
    check_delays(model, timing, limits)
}

/// Compares the delays at nominal parameters; longer ones that a fit comes to are cut.
pub(super) fn check_delays(
    model: &Model,
    timing: Timing,
    limits: &Limits,
) -> Result<(), SimulateError> {
    let nominal = |name: &str| model.parameter(name).map(|p| p.value);
    for delay in &model.delays {
        // A checked model has no delay that is not a finite number.
        let Ok(seconds) = delay.time.evaluate::<f64>(&nominal) else { continue };
        let what = format!("delay `{}` of {seconds} s", delay.name);
        limits.check(Resource::DelaySteps, what, (seconds / timing.h()).floor())?;
    }
    Ok(())
}
