//! Far above the noise, where what is believed ends before it: a list of laws that explains everything.
//!
//! As long as several effects are missing no single one comes near the noise, and there evidence is not to be trusted:
//! with a wrong model everything is significant. But a list of laws that comes down to the noise, in logs that it was not
//! fitted to as well, does not owe that to chance. So the best law is added while it takes its part of what
//! there is, and near the noise by evidence; the list counts only if noise is all that is left of it.

use fd_effect::Candidate;

use super::{
    by_evidence::{beginning, in_colour, is_credible},
    drive::Journey,
    finish::{finish, left},
    result::{End, Road},
};
use crate::{
    diagnose::{Cause, EffectSet, Wanted, follows_anything, is_a_pair},
    fit::FitError,
};

/// Causes in which a list gets to the noise from where it is begun. One of four that are missing may take little until the
/// others are there; on a real system, with a hundred small ones, no list gets there.
pub(super) const FURTHER: usize = 5;
/// Most that the list may leave of the held-out gap, in multiples of its floor.
const HELD_OUT: f64 = 1.5;

/// A list of laws that leaves noise alone, from one that is `believed` on; `None` where there is none in reach.
pub(super) fn to_the_noise(
    journey: &Journey<'_>,
    believed: &[Cause],
) -> Result<Option<Road>, FitError> {
    let begun = match believed {
        [] => beginning(journey)?,
        believed => journey.search.of_causes(believed),
    };
    let Some(begun) = begun else { return Ok(None) };
    let Some(near) = near(journey, begun.clone())? else { return Ok(None) };
    if !is_shown(journey, &begun, &near)? {
        return Ok(None);
    }
    in_colour(journey, near, |journey, found| {
        if found.end != End::AtTheNoise || !is_credible(journey, &found) {
            return Ok(None);
        }
        // Without held-out logs there is nothing to compare.
        let is_missed = HELD_OUT * journey.floor() < left(journey, &found.set)?;
        if is_missed { Ok(None) } else { finish(journey, found).map(Some) }
    })
}

/// Whether what took squares from `before` to `after` may be the best of so many laws that leave nothing together: that one takes
/// at least the mean.
pub(super) fn takes_the_mean([before, after]: [f64; 2], of: usize) -> bool {
    after <= (1.0 - 1.0 / of as f64) * before
}

/// Whether causes have taken their part of the squares of held-out errors as well.
fn is_shown(journey: &Journey<'_>, begun: &EffectSet, set: &EffectSet) -> Result<bool, FitError> {
    let (before, after) = (left(journey, begun)?, left(journey, set)?);
    let share = (set.members.len() - begun.members.len()) as f64 / FURTHER as f64;
    // Nothing is left of nothing where nothing was held out.
    Ok(before.is_nan() || (after / before).powi(2) <= 1.0 - share)
}

/// A set with as many laws more as it takes for the next one to come near the noise, each the best at first sight; `None`
/// where they do not take their shares.
fn near(journey: &Journey<'_>, mut set: EffectSet) -> Result<Option<EffectSet>, FitError> {
    let Journey { search, most, .. } = *journey;
    let laws = |candidate: &Candidate| !follows_anything(candidate);
    for rest in (1..=FURTHER).rev() {
        if search.is_stopped() || most <= set.members.len() {
            return Ok(None);
        }
        let more = journey.beside(&set, &Wanted { candidate: &laws, least: 0.0 })?;
        let next = more.into_iter().find(|more| is_a_pair(more.log_evidence, set.log_evidence));
        let Some(next) = next else { return Ok((!search.is_far(&set)).then_some(set)) };
        let next = search.in_short_steps(next);
        if !search.is_far(&next) {
            return Ok(Some(set));
        }
        if !takes_the_mean([&set, &next].map(|set| set.gap.powi(2)), rest) {
            return Ok(None);
        }
        set = next;
    }
    Ok(None)
}
