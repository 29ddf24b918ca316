//! From evidence to a verdict: which answers are tied, which are in doubt, how probable each one is.

mod beside;
mod by_evidence;
mod by_forecasts;
mod contest;
mod groups;
pub(super) mod horizons;
pub(super) mod judged;
mod missed;
mod pair_ties;
mod probabilities;
mod starts;
mod ties;
mod verdict;

pub(crate) use self::verdict::NAMED;
use self::{
    by_evidence::by_evidence, by_forecasts::by_forecasts, judged::Judged, missed::is_missed,
};
pub(super) use self::{
    contest::{Entrant, standings},
    groups::{groups, sides},
    probabilities::Probabilities,
    starts::{is_open, is_settled, prefer},
};
use super::{
    context::Context,
    monitor::Stage,
    weigh::{Weighed, answer::Fit, values::FittedValues},
};
use crate::{
    fit::{FitError, Log},
    shrink::as_begun,
};

/// Judges by evidence, or by forecasts where nothing comes near the noise, of the fitted logs or of those held out.
pub(super) fn judge<'a>(
    weighed: Weighed<'a>,
    context: &Context<'a>,
) -> Result<Judged<'a>, FitError> {
    let Context { case, monitor, .. } = context;
    let base = &weighed.singles.base;
    let held_out = Log::held_out(case.held_out, base.simulator(), case.logs, base.plan())?;
    let null = &weighed.singles.searched.null;
    let values = match &weighed.best.fit {
        Some(Fit { problem, minimum }) => FittedValues::of(problem, minimum),
        None => FittedValues::of(&null.problem, &null.minimum),
    };
    let sigma = &weighed.singles.searched.noise.sigma;
    let held_out = as_begun(base.simulator(), values.settled(), held_out, sigma)?;
    monitor.begin(Stage::Judge, 2);
    let judged = if weighed.is_far() || is_missed(&weighed, &held_out, context)? {
        by_forecasts(weighed, &held_out, context)?
    } else {
        by_evidence(weighed, context)
    };
    monitor.advance();
    Ok(judged)
}
