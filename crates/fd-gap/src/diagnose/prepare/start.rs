//! Logs that begin in motion: their states at the start are not where the model says.
//!
//! A log that was cut out of a longer run does not begin at rest. Held to the stated start, the fit spends its
//! parameters on the transient, and an effect that mimics a transient is blamed. With free starts, on the other
//! hand, what an integrator is off by is no finding any more. So both are tried where the beginnings speak for
//! motion, and the plainer reading is kept unless the other explains clearly more.

use std::sync::Arc;

use super::{Prepared, noise::KnownNoise, weighted_null_fit};
use crate::{
    diagnose::case::Case,
    fit::{FitError, Horizon, NullFit, Plan},
};

/// What a free start must gain, per unknown, beyond `ln n`: as much as something needs to be sure.
pub(in crate::diagnose) const SURE: f64 = 10.0;
/// Part of a log within which a start is forgotten …
const BEGINNING: f64 = 1.0 / 3.0;
/// … and the share of the gain that must lie there. What a free start gains all along the log, as the
/// offset of an integrator does, may as well be an effect …
const AT_THE_BEGINNING: f64 = 0.8;
/// … unless free starts alone come this near to the noise: what hardly damps never forgets how it began.
const DOWN_TO: f64 = 1.5;

/// The same logs with free starts, if their beginnings speak for motion: an F-test of what the free starts of
/// the model without any effect gain, which need not come near the noise.
pub(in crate::diagnose) fn in_motion(
    prepared: &Prepared,
    case: &Case<'_>,
    horizon: Horizon,
) -> Result<Option<Prepared>, FitError> {
    let simulator =
        case.nominal.patched(&prepared.model, prepared.null.problem.simulator().ts())?;
    let logs = prepared.null.problem.plan().logs.iter().map(|log| log.clone().in_motion());
    // Too short for so many unknowns, or lost from everywhere: then the log begins where it is said to.
    let Ok(plan) = Plan::of_logs(&*simulator, logs.collect(), horizon) else { return Ok(None) };
    let KnownNoise { stated, grids, spread, .. } = &prepared.noise;
    let Ok(null) = weighted_null_fit(&Arc::new(plan), &*simulator, stated, grids, spread) else {
        return Ok(None);
    };
    if !begins_in_motion(&prepared.null, &null) {
        return Ok(None);
    }
    let mut noise = prepared.noise.clone();
    noise.sigma.clone_from(&null.problem.weights().sigma);
    Ok(Some(Prepared { model: prepared.model.clone(), null, noise }))
}

/// Whether free starts explain so much more, and that in the beginning, that the logs cannot have begun where
/// the model says.
fn begins_in_motion(stated: &NullFit, free: &NullFit) -> bool {
    let sigma = &stated.problem.weights().sigma;
    // Sums of squares in the beginnings of all logs, and of all samples.
    let squares = |fit: &NullFit| -> Option<[f64; 2]> {
        let errors = fit.problem.clone().errors(&fit.minimum.z)?;
        let plan = fit.problem.plan();
        let mut sums = [0.0; 2];
        for ((signals, own), common) in errors.iter().zip(&fit.problem.weights().sigma).zip(sigma) {
            for (signal, segment) in signals.iter().zip(plan.segments()) {
                let end = BEGINNING * plan.logs[segment.log].samples() as f64;
                for (k, e) in signal.iter().enumerate().filter(|(_, e)| e.is_finite()) {
                    let square = (e * own / common).powi(2);
                    sums[0] += if ((segment.from + k) as f64) < end { square } else { 0.0 };
                    sums[1] += square;
                }
            }
        }
        Some(sums)
    };
    let (Some(before), Some(after)) = (squares(stated), squares(free)) else { return false };
    let n = stated.problem.plan().measured() as f64;
    let unknowns = free.problem.plan().own_variables().count() as f64;
    let gain = before[1] - after[1];
    let is_early = AT_THE_BEGINNING * gain < before[0] - after[0];
    let is_all = after[1] < DOWN_TO * DOWN_TO * n;
    (is_early || is_all) && unknowns * (n.ln() + SURE) * after[1] < n * gain
}
