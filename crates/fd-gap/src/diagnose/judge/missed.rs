//! Does the best explanation come near the noise of logs that no fit has seen?
//!
//! What explains the logs of the fit and nothing else is no law: a curve over time follows any force that comes from somewhere
//! else, and a hundred candidates have a hundred chances. Where held-out logs are missed, what is right about it is left to
//! forecasts, as where the fit itself is far from the noise. That a start is not known is not held against it.

use crate::{
    diagnose::{
        context::Context,
        weigh::{Weighed, answer::Fit, values::FittedValues},
    },
    fit::{FitError, Log},
    shrink::{Paths, errors_from_best_starts},
};

/// Whether the best answer, which has effects, leaves far more than noise of held-out logs, at the first horizon of the report.
/// A path is that of one run, and may be drawn anew where no law forecasts.
pub(super) fn is_missed(
    weighed: &Weighed<'_>,
    held_out: &[Log],
    context: &Context<'_>,
) -> Result<bool, FitError> {
    let Some(best) = &weighed.best.fit else { return Ok(false) };
    let horizon = context.settings.report_horizons.first();
    let Some(horizon) = horizon.filter(|_| !held_out.is_empty()) else { return Ok(false) };
    let (simulator, noise) = (weighed.singles.base.simulator(), &weighed.singles.searched.noise);
    // Nothing is known of what diverges.
    let is_far = |Fit { problem, minimum }: &Fit, paths| {
        let values = FittedValues::of(problem, minimum).with_paths(paths);
        let sigma = &noise.sigma;
        let errors =
            errors_from_best_starts(simulator, values.settled(), held_out, *horizon, sigma)?;
        Ok::<_, FitError>(errors.map(|errors| noise.is_far(&errors)))
    };
    if is_far(best, Paths::AsFitted)? != Some(true) {
        return Ok(false);
    }
    if best.paths() == Paths::AsFitted || is_far(best, Paths::Anew)? == Some(true) {
        return Ok(true);
    }
    let law = weighed.singles.first_law().and_then(|law| law.fit);
    Ok(law.map(|law| is_far(&law, Paths::AsFitted)).transpose()?.flatten() == Some(false))
}
