//! Near the noise: causes as long as the likelihood asks for more, each looked at again with all others there.
//!
//! What one cause or two explain best may be no part of what three explain better: a cause that was found first has
//! stood for those that were not there yet. So each is taken out again and sought anew beside all others, until the
//! list stays as it is: coordinate ascent of the evidence over the places of the list.

use fd_model::Record;

use super::{
    drive::Journey,
    finish::Found,
    growth::Growth,
    list::Listed,
    milestone::milestone,
    result::{End, Milestone},
};
use crate::{
    diagnose::{Cause, Monitor, Verdict, follows_anything, is_a_pair},
    fit::FitError,
};

/// Causes as long as evidence asks for more. `None` where one cause or two are all there is to say.
pub(super) fn by_evidence(
    journey: &Journey<'_>,
    monitor: &dyn Monitor,
) -> Result<Option<Found>, FitError> {
    let Journey { first, settings, lists, .. } = *journey;
    let is_single = matches!(first.verdict, Verdict::Cause | Verdict::Tied);
    let Some(leader) = first.causes.first() else { return Ok(None) };
    let is_law = |cause: &Cause| lists.candidate(&[], cause).is_some_and(|c| !follows_anything(&c));
    if is_single && !first.is_unexplained && is_law(leader) {
        return Ok(None);
    }
    let Some(list) = lists.of(beginning(journey)) else { return Ok(None) };
    let one = settings.for_one_law();
    let (list, end) = Growth::new(journey, &one, monitor).grown(list, None)?;
    let (list, end) = credible(journey, list, end);
    let list = largest_first(journey, list);
    let is_news = match first.verdict {
        Verdict::Pair => 2 < list.len(),
        // Laws that explain clearly more than what follows anything …
        Verdict::Cause | Verdict::Tied => is_a_pair(gained(journey, &list, leader), 0.0),
        _ => true,
    };
    // … and what nothing else explains must be explained to the end.
    let is_news =
        is_news && 1 < list.len() && (first.verdict == Verdict::Pair || end == End::AtTheNoise);
    if !is_news {
        return Ok(None);
    }
    let gaps = gaps(journey, &list)?;
    // What forecasts held-out logs no better than refitted parameters is no answer; without any, nothing is known of that.
    let is_missed = gaps.first().zip(gaps.last()).is_some_and(|(before, after)| before <= after);
    Ok((!is_missed).then_some(Found { list, gaps, end }))
}

/// The credible causes of a list.
pub(super) fn credible(journey: &Journey<'_>, list: Vec<Listed>, end: End) -> (Vec<Listed>, End) {
    let is_credible = |listed: &&Listed| listed.is_credible(journey.settings);
    if list.iter().filter(is_credible).count() == list.len() {
        return (list, end);
    }
    let kept = list.iter().filter(is_credible).map(|listed| listed.milestone.clone());
    (journey.lists.of(kept).unwrap_or_default(), End::NothingHelps)
}

/// A list in the order of the evidence of each beside all others.
pub(super) fn largest_first(journey: &Journey<'_>, list: Vec<Listed>) -> Vec<Listed> {
    let mut milestones: Vec<Milestone> = list.iter().map(|l| l.milestone.clone()).collect();
    milestones.sort_by(|a, b| b.cause.log_evidence.total_cmp(&a.cause.log_evidence));
    journey.lists.of(milestones).unwrap_or(list)
}

/// Log-likelihood that a list gains over a cause: `n ln` of what the two leave, root mean square.
fn gained(journey: &Journey<'_>, list: &[Listed], over: &Cause) -> f64 {
    let gaps = list.iter().map(|listed| listed.milestone.cause.gap);
    let left = gaps.fold(f64::INFINITY, f64::min);
    let values = |log: &Record| log.len() * log.outputs().len();
    let n: usize = journey.case.logs.iter().map(values).sum();
    n as f64 * (over.gap / left).ln()
}

/// What the first diagnosis found: a pair, if it is worth more than one cause, or the first cause.
pub(super) fn beginning(journey: &Journey<'_>) -> Vec<Milestone> {
    let Journey { first, horizon, lists, .. } = *journey;
    let is_law = |cause: &Cause| lists.candidate(&[], cause).is_some_and(|c| !follows_anything(&c));
    let single = first.causes.iter().find(|cause| is_law(cause));
    let alone = single.map_or(f64::NEG_INFINITY, |cause| cause.log_evidence);
    let pair = first.pairs.iter().find(|pair| pair.causes.iter().all(is_law));
    match pair.filter(|pair| is_a_pair(pair.log_evidence, alone)) {
        Some(pair) => {
            // What each has alone is no part of the pair's.
            let of_pair = |cause: &Cause| Cause { probability: 0.0, ..cause.clone() };
            pair.causes.iter().map(|c| milestone(first, &of_pair(c), horizon)).collect()
        }
        None => single.map(|cause| milestone(first, cause, horizon)).into_iter().collect(),
    }
}

/// Held-out gap without any cause, and after each.
pub(super) fn gaps(journey: &Journey<'_>, list: &[Listed]) -> Result<Vec<f64>, FitError> {
    let Some(judge) = journey.judge() else { return Ok(vec![f64::NAN; list.len() + 1]) };
    (0..=list.len()).map(|n| judge.left(journey.lists.model(&list[..n]))).collect()
}
