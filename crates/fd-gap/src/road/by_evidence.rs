//! Near the noise: causes as long as the likelihood asks for more, each looked at again with all others there.
//!
//! What one cause or two explain best may be no part of what three explain better: a cause that was found first has
//! stood for those that were not there yet. So each is taken out again and sought anew beside all others, until the
//! set stays as it is: coordinate ascent of the evidence over its members.

use super::{
    elimination::finish,
    result::{CauseList, End},
    selection::{Found, Selection},
};
use crate::{
    diagnose::{Cause, EffectSet, SetSearch, Verdict, is_a_pair},
    fit::FitError,
};

/// Causes as long as evidence asks for more. `None` where one cause or two are all there is to say.
pub(super) fn by_evidence(selection: &Selection<'_>) -> Result<Option<CauseList>, FitError> {
    let Some(set) = beginning(selection)? else { return Ok(None) };
    let first = selection.first;
    if first.verdict == Verdict::Pair && selection.next(&set)?.is_none() {
        return Ok(None);
    }
    in_colour(selection, set, |selection, found| {
        let n = found.set.members.len();
        let is_news = match (first.verdict, first.causes.first()) {
            (Verdict::Pair, _) => 2 < n,
            // Laws that explain clearly more than what follows anything …
            (Verdict::Cause | Verdict::Tied, Some(leader)) => {
                is_a_pair(gained(selection.search, &found.set, leader), 0.0)
            }
            _ => true,
        };
        // … and what nothing else explains must be explained to the end, by what is credible.
        let is_explained = first.verdict == Verdict::Pair || found.end == End::AtTheNoise;
        if !is_news || n < 2 || !is_explained || !is_credible(selection, &found) {
            return Ok(None);
        }
        let road = finish(selection, found)?;
        // What forecasts held-out logs no better than refitted parameters is no answer; without any, nothing is known of that.
        let is_missed = 1.0 <= road.unexplained + road.noise;
        Ok((!is_missed).then_some(road))
    })
}

/// A set that has grown, from one that it begins with, in white noise and then in that of the colour of what it leaves.
pub(super) fn in_colour(
    selection: &Selection<'_>,
    set: EffectSet,
    then: impl FnOnce(&Selection<'_>, Found) -> Result<Option<CauseList>, FitError>,
) -> Result<Option<CauseList>, FitError> {
    let Some(found) = selection.grown(set)? else { return Ok(None) };
    let Some(search) = selection.search.coloured(&found.set)? else {
        return then(selection, found);
    };
    let selection = Selection { search: &search, ..*selection };
    let all: Vec<usize> = (0..found.set.members.len()).collect();
    let Some(set) = search.only(&found.set, &all) else { return Ok(None) };
    match selection.grown(set)? {
        Some(found) => then(&selection, found),
        None => Ok(None),
    }
}

/// Whether nothing beside the same others explained clearly better than any of the causes: a law that a curve without a law
/// beats by far stands for something else.
pub(super) fn is_credible(selection: &Selection<'_>, found: &Found) -> bool {
    let least = 1.0 / selection.search.settings().bayes_factor;
    found.named.iter().all(|named| least <= named.odds)
}

/// Log-likelihood that a set gains over a cause: `n ln` of what the two leave, root mean square.
fn gained(search: &SetSearch<'_>, set: &EffectSet, over: &Cause) -> f64 {
    search.measured() as f64 * (over.gap / set.gap).ln()
}

/// What the first diagnosis found: a pair, if it is worth more than one cause, or the first cause.
fn beginning(selection: &Selection<'_>) -> Result<Option<EffectSet>, FitError> {
    let Selection { first, search, .. } = *selection;
    let single = first.causes.iter().find(|cause| search.is_law(cause));
    let alone = single.map_or(f64::NEG_INFINITY, |cause| cause.log_evidence);
    let pair = first.pairs.iter().find(|pair| pair.causes.iter().all(|c| search.is_law(c)));
    let causes = match pair.filter(|pair| is_a_pair(pair.log_evidence, alone)) {
        Some(pair) => pair.causes.as_slice(),
        None => single.map_or(&[][..], std::slice::from_ref),
    };
    match causes {
        [] => Ok(None),
        causes => search.of_causes(causes).map(Some).ok_or(FitError::Diverged),
    }
}
