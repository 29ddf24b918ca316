//! Logs that begin in motion: their states at the start are not where the model says.
//!
//! A log that was cut out of a longer run does not begin at rest. Held to the stated start, the fit spends its
//! parameters on the transient, and an effect that mimics a transient is blamed. With free starts, on the other
//! hand, what an integrator is off by is no finding any more. So both are tried where free starts explain more, and the
//! plainer reading is kept unless the other explains clearly more beside effects as well.

use std::sync::Arc;

use super::{Prepared, noise::KnownNoise, weighted_null_fit};
use crate::{
    diagnose::{
        case::Case,
        settings::{Beginning, Settings},
    },
    evidence::grades::BEYOND_DOUBT,
    fit::{FitError, NullFit, Plan},
};

/// The same logs with free starts, if these explain so much more that the logs cannot have begun where the model says: an
/// F-test without any effect, of errors that need not come near the noise; or if a setting says so.
pub(in crate::diagnose) fn in_motion(
    prepared: &Prepared,
    case: &Case<'_>,
    settings: &Settings,
) -> Result<Option<Prepared>, FitError> {
    if settings.without.free_starts || settings.beginning == Beginning::AsStated {
        return Ok(None);
    }
    let simulator =
        case.nominal.patched(&prepared.model, prepared.null.problem.simulator().ts())?;
    let logs = prepared.null.problem.plan().logs.iter().map(|log| log.clone().in_motion());
    // Too short for so many unknowns, or lost from everywhere: then the log begins where it is said to.
    let Ok(plan) = Plan::of_logs(&*simulator, logs.collect(), settings.horizon) else {
        return Ok(None);
    };
    let KnownNoise { stated, grids, spread, .. } = &prepared.noise;
    let Ok(null) = weighted_null_fit(&Arc::new(plan), &*simulator, stated, grids, spread) else {
        return Ok(None);
    };
    if settings.beginning == Beginning::Either && !begins_in_motion(&prepared.null, &null) {
        return Ok(None);
    }
    let mut noise = prepared.noise.clone();
    noise.sigma.clone_from(&null.problem.weights().sigma);
    Ok(Some(Prepared { model: prepared.model.clone(), null, noise }))
}

/// Whether free starts explain clearly more; not where a simulation diverges.
fn begins_in_motion(stated: &NullFit, free: &NullFit) -> bool {
    let sigma = &stated.problem.weights().sigma;
    let both = (squares_of(stated, sigma), squares_of(free, sigma));
    let (Some(before), Some(after)) = both else { return false };
    let plan = free.problem.plan();
    needed(plan) * after < plan.measured() as f64 * (before - after)
}

/// What free starts must gain where they are not the plainer answer, in log-likelihood.
pub(in crate::diagnose) fn needed(free: &Plan) -> f64 {
    let (n, unknowns) = (free.measured() as f64, free.own_variables().count() as f64);
    unknowns * (n.ln() + BEYOND_DOUBT)
}

/// Sum of squares that a fit leaves, in `common` units; `None` where its simulation diverges.
pub(in crate::diagnose) fn squares_of(fit: &NullFit, common: &[f64]) -> Option<f64> {
    let errors = fit.problem.clone().errors(&fit.minimum.z)?;
    Some(squares(&errors, &fit.problem.weights().sigma, common))
}

/// Sum of squares of errors that are in units of `own`, in common ones.
pub(in crate::diagnose) fn squares(errors: &[Vec<Vec<f64>>], own: &[f64], common: &[f64]) -> f64 {
    let of = |((signals, own), common): ((&Vec<Vec<f64>>, &f64), &f64)| -> f64 {
        let finite = signals.iter().flatten().filter(|e| e.is_finite());
        finite.map(|e| (e * own / common).powi(2)).sum()
    };
    errors.iter().zip(own).zip(common).map(of).sum()
}
