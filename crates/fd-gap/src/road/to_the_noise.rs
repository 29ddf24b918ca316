//! Far above the noise, where what is believed ends before it: a list of laws that explains everything.
//!
//! As long as several effects are missing no single one comes near the noise, and there evidence is not to be trusted:
//! with a wrong model everything is significant. But a list of laws that comes down to the noise, in logs that it was not
//! fitted to as well, does not owe that to chance. So causes are added by evidence while together they take their part of
//! what there was, and the list counts only if noise is all that is left of it.

use super::{
    by_evidence::{beginning, credible, gaps, largest_first},
    drive::Journey,
    finish::Found,
    growth::Growth,
    list::Listed,
    result::End,
};
use crate::{
    diagnose::{Diagnosis, Monitor},
    fit::FitError,
};

/// Most diagnoses on the way.
const DIAGNOSES: usize = 16;
/// Causes in which a list gets to the noise from where it is begun, each with an equal share of the squares. One of four that are
/// missing may take little until the others are there; on a real system, with a hundred small ones, no list gets there.
const FURTHER: usize = 5;
/// Most that the list may leave of the held-out gap, in multiples of its floor.
const HELD_OUT: f64 = 1.5;

/// A list of laws that leaves noise alone, from one that is `believed` and the diagnosis `beside` it on; `None` where
/// there is none in reach.
pub(super) fn to_the_noise(
    journey: &Journey<'_>,
    believed: &[Listed],
    beside: Diagnosis,
    monitor: &dyn Monitor,
) -> Result<Option<Found>, FitError> {
    let (list, beside) = match believed {
        [] => (journey.lists.of(beginning(journey)), None),
        _ => (Some(believed.to_vec()), Some(beside)),
    };
    let Some(list) = list else { return Ok(None) };
    if list.is_empty() || monitor.is_stopped() {
        return Ok(None);
    }
    let one = journey.settings.for_one_law();
    let (list, end) =
        Growth::new(journey, &one, monitor, DIAGNOSES, Some(FURTHER)).grown(list, beside)?;
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
