//! From evidence to a verdict: which answers tie, what is doubted, how probable each is.

mod beside;
mod by_evidence;
mod by_forecasts;
mod contest;
mod groups;
mod horizons;
pub(super) mod judged;
mod pair_ties;
mod probabilities;
mod starts;
mod ties;
mod validation;
mod verdict;

use self::{by_evidence::by_evidence, by_forecasts::by_forecasts, judged::Judged};
pub(super) use self::{
    groups::{groups, sides},
    probabilities::Probabilities,
    starts::prefer,
};
use super::{context::Context, monitor::Stage, weigh::Weighed};
use crate::fit::{FitError, Log};

/// Judges by evidence, or by forecasts where nothing comes near the noise.
pub(super) fn judge<'a>(
    weighed: Weighed<'a>,
    context: &Context<'a>,
) -> Result<Judged<'a>, FitError> {
    let Context { case, monitor, .. } = context;
    let base = &weighed.singles.base;
    let held_out = Log::held_out(case.held_out, base.simulator(), case.logs, base.plan())?;
    monitor.begin(Stage::Judge, 2);
    let judged = if weighed.is_far() {
        by_forecasts(weighed, &held_out, context)?
    } else {
        by_evidence(weighed, &held_out, context)?
    };
    monitor.advance();
    Ok(judged)
}
