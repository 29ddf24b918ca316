//! Far above the noise: the best law at each step, and then how far all of them are believed together.
//!
//! As long as several effects are missing, each of them explains a part of the gap: three axes that rub, each with a friction
//! of its own, are three laws of which none explains half. So a set grows first, by the law that forecasts best beside it, as
//! long as that takes its part of what is left. Each law is judged afterwards, with all the others there: how often it beats
//! what was tried in its place, and how much it explains of what the others leave.

use fd_effect::Candidate;

use super::{
    drive::{Found, Journey, Named},
    finish::left,
    result::End,
};
use crate::{
    diagnose::{Cause, Diagnosis, EffectSet, NAMED, Objection, Round, Wanted, follows_anything},
    fit::FitError,
};

/// A set that has grown, and the rounds in which it did.
pub(super) struct Grown {
    pub(super) set: EffectSet,
    pub(super) end: End,
    steps: Vec<Step>,
}

/// A round, and the place of what was taken from it.
struct Step {
    round: Round,
    place: usize,
}

/// The first law of a diagnosis, and what takes its part of what is left beside it; `None` where there is no law.
pub(super) fn grown(journey: &Journey<'_>) -> Result<Option<Grown>, FitError> {
    let Journey { first, search, most, .. } = *journey;
    // As many as are fitted beside a set.
    let rivals = search.settings().shortlist;
    let causes = first.causes.iter().filter(|cause| search.is_law(cause)).take(rivals);
    let alone = causes.filter_map(|cause| search.of_causes(std::slice::from_ref(cause)));
    let round = search.round(&search.none()?, alone.collect())?;
    let Some(set) = round.more.first().cloned() else { return Ok(None) };
    let mut grown = Grown { set, end: End::NothingHelps, steps: vec![Step { round, place: 0 }] };
    let laws = |candidate: &Candidate| !follows_anything(candidate);
    let mut before = journey.above_the_floor(&grown.set)?;
    loop {
        if search.is_noise(&grown.set) {
            grown.end = End::AtTheNoise;
        }
        let rest = most.saturating_sub(grown.set.members.len());
        if rest == 0 {
            grown.end = End::Enough;
        }
        if grown.end != End::NothingHelps || search.is_stopped() {
            return Ok(Some(grown));
        }
        let more = search.beside(&grown.set, &Wanted { candidate: &laws, least: 0.0 })?;
        let round = search.round(&grown.set, more)?;
        let standings = search.standings(&round, &round.forecasts, journey.floor());
        let best = standings.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((place, _)) = best else { return Ok(Some(grown)) };
        let set = round.more[place].clone();
        let after = journey.above_the_floor(&set)?;
        if !takes_the_mean([before, after], rest) {
            return Ok(Some(grown));
        }
        grown.steps.push(Step { round, place });
        (grown.set, before) = (set, after);
    }
}

/// As few laws of a set, in the order in which they were found, as are more probable than not all together, and those after
/// them that remain so; `None` where there are none.
pub(super) fn believed(journey: &Journey<'_>, grown: &Grown) -> Option<Found> {
    let Journey { first, search, .. } = *journey;
    let steps = &grown.steps;
    if first.objections.iter().any(Objection::forbids) {
        return None;
    }
    // Beside what was found up to the last one.
    let probability = |Step { round, place }: &Step, last: &Step| {
        let forecasts = round.forecasts.beside(place + 1, &last.round.forecasts, last.place + 1);
        let standings = search.standings(round, &forecasts, journey.floor());
        probability_of(*place, round, &standings)
    };
    let together = |last: usize| -> Vec<Named> {
        let of = |step| unrivalled(probability(step, &steps[last]), &steps[last]);
        steps[..=last].iter().map(of).collect()
    };
    let is_believed = |named: &Vec<Named>| NAMED < named.iter().map(|n| n.probability).product();
    // What is believed of one alone, the diagnosis has said.
    let alone = first.causes.first().filter(|cause| NAMED < cause.probability);
    let mut named = match alone.filter(|cause| search.is_law(cause)) {
        Some(cause) => vec![of_first(first, cause)],
        None => (1..steps.len()).map(together).find(is_believed)?,
    };
    while let Some(next) = steps.get(named.len()) {
        named.push(unrivalled(probability(next, next), next));
        if !is_believed(&named) {
            named.pop();
            break;
        }
    }
    let Step { round, place } = &steps[named.len() - 1];
    let end = if named.len() == steps.len() { grown.end } else { End::NothingHelps };
    Some(Found { set: round.more[*place].clone(), named, end })
}

/// What is said of a cause that nothing is tied with.
fn unrivalled(probability: f64, Step { round, place }: &Step) -> Named {
    let log_evidence = round.more[*place].log_evidence;
    Named { log_evidence, probability, tied: Vec::new(), odds: 1.0 }
}

/// The probability of the cause of which a law is at a place of a round.
fn probability_of(place: usize, round: &Round, standings: &[(usize, f64)]) -> f64 {
    let cause = |place: usize| round.more[place].members.last().map(Candidate::identity);
    let own = standings.iter().find(|(best, _)| cause(*best) == cause(place));
    own.map_or(0.0, |(_, probability)| *probability)
}

/// Whether what took squares from `before` to `after` may be the best of so many laws that leave nothing together: that one takes
/// at least the mean.
pub(super) fn takes_the_mean([before, after]: [f64; 2], of: usize) -> bool {
    after <= (1.0 - 1.0 / of as f64) * before
}

impl Journey<'_> {
    /// Squares that a set leaves of held-out logs above their floor, or of the fitted ones above the noise without any.
    fn above_the_floor(&self, set: &EffectSet) -> Result<f64, FitError> {
        let (left, floor) = (left(self, set)?, self.floor());
        let [left, floor] = if left.is_nan() { [set.gap, 1.0] } else { [left, floor] };
        Ok((left.powi(2) - floor.powi(2)).max(0.0))
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
