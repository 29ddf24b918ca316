//! Far above the noise, where what is believed ends before it: a list of laws that explains everything.
//!
//! As long as several effects are missing no single one comes near the noise, and there evidence is not to be trusted:
//! with a wrong model everything is significant. But a list of laws that comes down to the noise, in logs that it was not
//! fitted to as well, does not owe that to chance. So the best law at first sight is added while it takes its part of what
//! there is, and near the noise by evidence; the list counts only if noise is all that is left of it.

use super::{
    by_evidence::{beginning, credible, gaps, largest_first},
    drive::Journey,
    finish::Found,
    growth::Growth,
    list::Listed,
    result::{End, Milestone},
};
use crate::{
    diagnose::{Monitor, Settings, follows_anything, glimpse, is_a_pair},
    fit::FitError,
};

/// Causes in which a list gets to the noise from where it is begun. One of four that are missing may take little until the
/// others are there; on a real system, with a hundred small ones, no list gets there.
const FURTHER: usize = 5;
/// Most that the list may leave of the held-out gap, in multiples of its floor.
const HELD_OUT: f64 = 1.5;

/// A list of laws that leaves noise alone, from one that is `believed` on; `None` where there is none in reach.
pub(super) fn to_the_noise(
    journey: &Journey<'_>,
    believed: &[Listed],
    monitor: &dyn Monitor,
) -> Result<Option<Found>, FitError> {
    let list = match believed {
        [] => journey.lists.of(beginning(journey)).unwrap_or_default(),
        _ => believed.to_vec(),
    };
    if list.is_empty() {
        return Ok(None);
    }
    let one = journey.settings.for_one_law();
    let begun = list.clone();
    let Some(list) = near(journey, list, &one, monitor)? else { return Ok(None) };
    if !is_shown(journey, &begun, &list)? {
        return Ok(None);
    }
    let grown = Growth::new(journey, &one, monitor).grown_near(list)?;
    let Some((list, end)) = grown else { return Ok(None) };
    let (list, end) = credible(journey, list, end);
    if end != End::AtTheNoise || list.is_empty() {
        return Ok(None);
    }
    let list = largest_first(journey, list);
    let gaps = gaps(journey, &list)?;
    let floor = journey.judge().map_or(f64::NAN, |judge| judge.floor);
    // Without held-out logs there is nothing to compare.
    let is_held_out = !gaps.last().is_some_and(|left| HELD_OUT * floor < *left);
    Ok(is_held_out.then_some(Found { list, gaps, end }))
}

/// Whether causes have taken their part of the squares of held-out errors as well.
fn is_shown(journey: &Journey<'_>, begun: &[Listed], list: &[Listed]) -> Result<bool, FitError> {
    let Some(judge) = journey.judge() else { return Ok(true) };
    let left = |list| judge.left(journey.lists.model(list));
    let (before, after) = (left(begun)?, left(list)?);
    let share = (list.len() - begun.len()) as f64 / FURTHER as f64;
    Ok((after / before).powi(2) <= 1.0 - share)
}

/// A list with as many laws more as it takes for the next one to come near the noise, each the best at first sight; `None`
/// where they do not take their shares: the best of so many that leave nothing together takes at least the mean.
fn near(
    journey: &Journey<'_>,
    mut list: Vec<Listed>,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Option<Vec<Listed>>, FitError> {
    let Journey { lists, most, .. } = *journey;
    for rest in (1..=FURTHER).rev() {
        if monitor.is_stopped() || most <= list.len() {
            return Ok(None);
        }
        let seen = journey.beside(&list, None, |case| glimpse(case, settings, monitor))?;
        if !seen.is_far {
            return Ok(Some(list));
        }
        let evident = seen.causes.into_iter().filter(|cause| is_a_pair(cause.log_evidence, 0.0));
        let mut laws = evident
            .filter_map(|cause| lists.listed(&list, Milestone::glimpsed(cause)))
            .filter(|listed| !follows_anything(&listed.candidate));
        let Some(next) = laws.next() else { return Ok(None) };
        let left = (next.milestone.cause.gap / seen.refit).powi(2);
        if 1.0 - 1.0 / (rest as f64) < left {
            return Ok(None);
        }
        list = lists.with(list, next);
    }
    Ok(None)
}
