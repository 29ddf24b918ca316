//! The causes that a log shows at first sight.
//!
//! *When not to use:* for an answer: nothing is said of pairs, of ties, of the integration step, of held-out logs.

use fd_model::Record;

use super::{
    candidates::Candidates,
    case::Case,
    context::Context,
    monitor::Monitor,
    prepare::{prepare, start::in_motion},
    result::Cause,
    search::search_roughly,
    settings::Settings,
    weigh::weigh_alone,
};
use crate::{fit::FitError, shrink::gap};

/// Single causes, and how far the best of them is from the noise.
#[derive(Debug)]
pub(crate) struct Glimpse {
    /// The causes, the most evidence first.
    pub(crate) causes: Vec<Cause>,
    /// What the refitted model leaves, root mean square, in sigma.
    pub(crate) refit: f64,
    /// Whether even the best is so far above the noise that likelihoods are no use.
    pub(crate) is_far: bool,
}

/// Samples of each log that are looked at: as many as it takes to tell a large effect.
const ENOUGH: usize = 1000;

/// Fits the most promising causes to the beginnings of the logs, the best of them to the end. Logs begin in motion where their
/// beginnings speak for that.
pub(crate) fn glimpse(
    case: &Case<'_>,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Glimpse, FitError> {
    let candidates = Candidates::of(case.suspects);
    let beginning = |log: &Record| log.slice(0, ENOUGH.min(log.len()));
    let logs: Vec<Record> = case.logs.iter().map(beginning).collect();
    let case = Case { logs: &logs, ..*case };
    let settings = &Settings { finalists: 1, ..settings.clone() };
    let context = Context { case, candidates: &candidates, settings, monitor };
    let prepared = prepare(&case, settings.horizon)?;
    let prepared = in_motion(&prepared, &case, settings)?.unwrap_or(prepared);
    let weighed = weigh_alone(search_roughly(prepared, &context)?, &context)?;
    let is_far = weighed.is_far();
    let singles = weighed.singles;
    Ok(Glimpse {
        refit: gap(&singles.refit.errors),
        causes: singles.causes.into_iter().map(|ranked| ranked.cause).collect(),
        is_far,
    })
}
