//! From far above the noise down to it: a list of laws that explains everything.
//!
//! As long as several effects are missing no single one comes near the noise, and there evidence is not to be trusted:
//! with a wrong model everything is significant. But a list of laws that comes down to the noise, in logs that it was not
//! fitted to as well, does not owe that to chance. So what has grown as near to the noise goes on by evidence, and counts only
//! if noise is all that is left of it.

use super::{
    by_evidence::{in_colour, is_credible},
    drive::Journey,
    finish::{finish, left},
    result::{End, Road},
};
use crate::{diagnose::EffectSet, fit::FitError};

/// Most that the list may leave of the held-out gap, in multiples of its floor.
const HELD_OUT: f64 = 1.5;

/// A list of laws that leaves noise alone, from a set on that comes near it; `None` where there is none in reach.
pub(super) fn to_the_noise(
    journey: &Journey<'_>,
    set: EffectSet,
) -> Result<Option<Road>, FitError> {
    if journey.search.is_far(&set) {
        return Ok(None);
    }
    in_colour(journey, set, |journey, found| {
        if found.end != End::AtTheNoise || !is_credible(journey, &found) {
            return Ok(None);
        }
        // Without held-out logs there is nothing to compare.
        let is_missed = HELD_OUT * journey.floor() < left(journey, &found.set)?;
        if is_missed { Ok(None) } else { finish(journey, found).map(Some) }
    })
}
