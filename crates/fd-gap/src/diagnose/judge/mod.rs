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
mod through_windows;
mod ties;
mod verdict;

pub(crate) use self::verdict::NAMED;
use self::{
    by_evidence::by_evidence,
    by_forecasts::by_forecasts,
    horizons::memory,
    judged::Judged,
    missed::is_missed,
    through_windows::{through_windows, windows_where_lost},
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
    context.monitor.begin(Stage::Judge, 2);
    let held_out = begun(&weighed, context)?;
    let judged = if is_beyond(&weighed, &held_out, context)? {
        far_from_the_noise(weighed, &held_out, context)?
    } else {
        by_evidence(weighed, context)
    };
    context.monitor.advance();
    Ok(judged)
}

/// Judges by forecasts, unless fits through windows bring something near the noise.
fn far_from_the_noise<'a>(
    weighed: Weighed<'a>,
    held_out: &[Log],
    context: &Context<'a>,
) -> Result<Judged<'a>, FitError> {
    let simulator = weighed.singles.base.simulator().boxed();
    let horizons = memory(&*simulator, &weighed.singles.searched.null, held_out);
    let Some(windows) = windows_where_lost(&weighed, &horizons, context) else {
        return by_forecasts(weighed, held_out, horizons, None, context);
    };
    let (weighed, in_windows) = through_windows(weighed, windows, context)?;
    let held_out = begun(&weighed, context)?;
    if in_windows || is_beyond(&weighed, &held_out, context)? {
        by_forecasts(weighed, &held_out, horizons, in_windows.then_some(windows), context)
    } else {
        Ok(by_evidence(weighed, context))
    }
}

/// Whether nothing comes near the noise.
fn is_beyond(
    weighed: &Weighed<'_>,
    held_out: &[Log],
    context: &Context<'_>,
) -> Result<bool, FitError> {
    Ok(weighed.is_far() || is_missed(weighed, held_out, context)?)
}

/// The held-out logs, begun where the best answer says.
fn begun(weighed: &Weighed<'_>, context: &Context<'_>) -> Result<Vec<Log>, FitError> {
    let Context { case, .. } = context;
    let base = &weighed.singles.base;
    let held_out = Log::held_out(case.held_out, base.simulator(), case.logs, &base.plan().logs)?;
    let null = &weighed.singles.searched.null;
    let values = match &weighed.best.fit {
        Some(Fit { problem, minimum }) => FittedValues::of(problem, minimum),
        None => FittedValues::of(&null.problem, &null.minimum),
    };
    let sigma = &weighed.singles.searched.noise.sigma;
    as_begun(base.simulator(), values.settled(), held_out, sigma)
}
