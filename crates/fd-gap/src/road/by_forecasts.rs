//! Far above the noise: the best law at each step, and then how far all of them are believed together.
//!
//! As long as several effects are missing, each of them explains a part of the gap: three axes that rub, each with a friction
//! of its own, are three laws of which none explains half. So a set grows first, by the law that forecasts best beside it, as
//! long as that takes its part of what is left. Each law is judged afterwards, with all the others there: how often it beats
//! what was tried in its place, and how much it explains of what the others leave.

use fd_effect::Candidate;

use super::{
    elimination::left,
    floating::{above_the_noise, takes_the_mean},
    result::End,
    selection::{Found, Named, Selection},
};
use crate::{
    diagnose::{Cause, Diagnosis, EffectSet, NAMED, Objection, Round, Wanted, follows_anything},
    fit::FitError,
};

/// The rounds in which a set has grown, at least one, and why it ends there.
pub(super) struct Grown {
    steps: Vec<Step>,
    end: End,
}

impl Grown {
    /// What it has come to.
    pub(super) fn set(&self) -> Option<&EffectSet> {
        self.steps.last().map(Step::set)
    }
}

/// A round, and the place of what was taken from it.
struct Step {
    round: Round,
    place: usize,
}

impl Step {
    fn set(&self) -> &EffectSet {
        &self.round.more[self.place]
    }
}

/// The cause that a diagnosis believes in alone, if it is a law and nothing forbids it.
pub(super) fn believed_alone<'a>(selection: &Selection<'a>) -> Option<&'a Cause> {
    let first = selection.first;
    let cause = first.causes.first().filter(|cause| NAMED < cause.probability)?;
    (!is_forbidden(first) && selection.search.is_law(cause)).then_some(cause)
}

fn is_forbidden(first: &Diagnosis) -> bool {
    first.objections.iter().any(Objection::forbids)
}

/// The first law of a diagnosis, and what takes its part of what is left beside it; `None` where there is no law.
pub(super) fn grown(selection: &Selection<'_>) -> Result<Option<Grown>, FitError> {
    let Selection { first, search, most, .. } = *selection;
    // As many as are fitted beside a set.
    let rivals = search.settings().shortlist;
    let causes = first.causes.iter().filter(|cause| search.is_law(cause)).take(rivals);
    let alone = causes.filter_map(|cause| search.of_causes(std::slice::from_ref(cause)));
    let round = search.round(&search.none()?, alone.collect())?;
    if round.more.is_empty() {
        return Ok(None);
    }
    let mut last = Step { round, place: 0 };
    let mut before = selection.above_the_floor(last.set())?;
    let mut steps = Vec::new();
    let laws = |candidate: &Candidate| !follows_anything(candidate);
    let end = loop {
        let set = last.set();
        let rest = most.saturating_sub(set.members.len());
        if rest == 0 {
            break End::Enough;
        }
        if search.is_noise(set) {
            break End::AtTheNoise;
        }
        if search.is_stopped() {
            break End::NothingHelps;
        }
        let more = search.beside(set, &Wanted { candidate: &laws, least: 0.0 })?;
        let round = search.round(set, more)?;
        let standings = search.standings(&round, &round.forecasts, selection.floor());
        let best = standings.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((place, _)) = best else { break End::NothingHelps };
        let next = Step { round, place };
        let after = selection.above_the_floor(next.set())?;
        if !takes_the_mean([before, after], rest) {
            break End::NothingHelps;
        }
        steps.push(std::mem::replace(&mut last, next));
        before = after;
    };
    steps.push(last);
    Ok(Some(Grown { steps, end }))
}

/// As few laws of a set, in the order in which they were found, as are more probable than not all together, and those after
/// them that remain so; `None` where there are none.
pub(super) fn believed(selection: &Selection<'_>, grown: &Grown) -> Option<Found> {
    let Selection { first, search, .. } = *selection;
    let Grown { steps, end } = grown;
    if is_forbidden(first) {
        return None;
    }
    // Of what was found in a step, beside what was found up to the last one.
    let named = |i: usize, last: usize| {
        let (Step { round, place }, last) = (&steps[i], &steps[last]);
        let forecasts = round.forecasts.beside(place + 1, &last.round.forecasts, last.place + 1);
        let standings = search.standings(round, &forecasts, selection.floor());
        let before = steps[..i].last().map_or(0.0, |before| before.set().log_evidence);
        Named {
            log_evidence: steps[i].set().log_evidence - before,
            probability: probability_of(*place, round, &standings),
            tied: Vec::new(),
            odds: 1.0,
        }
    };
    let together = |last: usize| -> Vec<Named> { (0..=last).map(|i| named(i, last)).collect() };
    let is_believed = |named: &Vec<Named>| NAMED < named.iter().map(|n| n.probability).product();
    // What is believed of one alone, the diagnosis has said.
    let mut all = match believed_alone(selection) {
        Some(cause) => vec![of_first(first, cause)],
        None => (1..steps.len()).map(together).find(is_believed)?,
    };
    while all.len() < steps.len() {
        all.push(named(all.len(), all.len()));
        if !is_believed(&all) {
            all.pop();
            break;
        }
    }
    let end = if all.len() == steps.len() { *end } else { End::NothingHelps };
    Some(Found { set: steps[all.len() - 1].set().clone(), named: all, end })
}

/// The probability of the cause of which a law is at a place of a round.
fn probability_of(place: usize, round: &Round, standings: &[(usize, f64)]) -> f64 {
    let cause = |place: usize| round.more[place].members.last().map(Candidate::identity);
    let own = standings.iter().find(|(best, _)| cause(*best) == cause(place));
    own.map_or(0.0, |(_, probability)| *probability)
}

impl Selection<'_> {
    /// Squares that a set leaves of held-out logs above their floor, or of the fitted ones above the noise without any.
    fn above_the_floor(&self, set: &EffectSet) -> Result<f64, FitError> {
        let left = left(self, set)?;
        let above = (left.powi(2) - self.floor().powi(2)).max(0.0);
        Ok(if left.is_nan() { above_the_noise(set) } else { above })
    }
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
