//! Far above the noise: one cause after another, as long as they are believed together.

use fd_effect::Candidate;

use super::{
    drive::{Found, Journey, Named},
    finish::left,
    result::End,
};
use crate::{
    diagnose::{Cause, Diagnosis, NAMED, Objection, Wanted, follows_anything},
    fit::FitError,
};

/// Causes as long as the set with them is more probable than not and leaves less of held-out logs; `None` where not even the
/// first is believed.
pub(super) fn beyond(journey: &Journey<'_>) -> Result<Option<Found>, FitError> {
    let Journey { first, search, most, .. } = *journey;
    let is_forbidden = first.objections.iter().any(Objection::forbids);
    let cause = first.causes.first().filter(|cause| !is_forbidden && search.is_law(cause));
    let Some(cause) = cause.filter(|cause| NAMED < cause.probability) else { return Ok(None) };
    let Some(mut set) = search.of_causes(std::slice::from_ref(cause)) else { return Ok(None) };
    let mut named = vec![of_first(first, cause)];
    let mut before = left(journey, &set)?;
    let laws = |candidate: &Candidate| !follows_anything(candidate);
    let end = loop {
        if set.members.len() == most {
            break End::Enough;
        }
        if search.is_stopped() {
            break End::NothingHelps;
        }
        if search.is_noise(&set) {
            break End::AtTheNoise;
        }
        let mut more = search.beside(&set, &Wanted { candidate: &laws, least: 0.0 })?;
        let standings = search.contest(&set, &more, journey.floor())?;
        let best = standings.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((place, probability)) = best else { break End::NothingHelps };
        let next = more.swap_remove(place);
        let together: f64 = named.iter().map(|named| named.probability).product();
        let after = left(journey, &next)?;
        if together * probability <= NAMED || before <= after {
            break End::NothingHelps;
        }
        let log_evidence = next.log_evidence - set.log_evidence;
        named.push(Named { log_evidence, probability, tied: Vec::new(), odds: 1.0 });
        (set, before) = (next, after);
    };
    Ok(Some(Found { set, named, end }))
}

/// What a diagnosis says of its first cause.
fn of_first(first: &Diagnosis, cause: &Cause) -> Named {
    let tied = first.tied.iter().skip(1).filter_map(|id| first.cause(*id));
    let tied: Vec<&Cause> = tied.collect();
    let together = tied.iter().map(|tied| tied.probability).sum::<f64>() + cause.probability;
    Named {
        log_evidence: cause.log_evidence,
        probability: together.min(1.0),
        tied: tied.iter().map(|tied| tied.label.to_owned()).collect(),
        odds: 1.0,
    }
}
