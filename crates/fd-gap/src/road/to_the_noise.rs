//! From far above the noise down to it: a list of laws that explains everything.
//!
//! As long as several effects are missing no single one comes near the noise, and there evidence is not to be trusted:
//! with a wrong model everything is significant. But a list of laws that comes down to the noise, in logs that it was not
//! fitted to as well, does not owe that to chance. So what has grown as near to the noise goes on by evidence, and counts only
//! if noise is all that is left of it.

use super::{
    by_evidence::{in_colour, is_credible},
    elimination::{finish, left},
    result::{CauseList, End},
    selection::Selection,
};
use crate::{diagnose::EffectSet, fit::FitError, quality::EXPLAINED};

/// A list of laws that leaves noise alone, from a set on that comes near it; `None` where there is none in reach.
pub(super) fn to_the_noise(
    selection: &Selection<'_>,
    set: EffectSet,
) -> Result<Option<CauseList>, FitError> {
    if selection.search.is_far(&set) {
        return Ok(None);
    }
    in_colour(selection, set, |selection, found| {
        if found.end != End::AtTheNoise || !is_credible(selection, &found) {
            return Ok(None);
        }
        // Without held-out logs there is nothing to compare.
        let is_missed = EXPLAINED * selection.floor() < left(selection, &found.set)?;
        if is_missed { Ok(None) } else { finish(selection, found).map(Some) }
    })
}
