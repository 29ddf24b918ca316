//! Near the noise: causes as long as the likelihood asks for more, each looked at again with all others there.
//!
//! What one cause or two explain best may be no part of what three explain better: a cause that was found first has
//! stood for those that were not there yet. So each is taken out again and sought anew beside all others, until the
//! list stays as it is: coordinate ascent of the evidence over the places of the list.

use std::cell::Cell;

use fd_effect::Suspects;
use fd_model::Record;
use fd_sim::model::Model;

use super::{
    adjustable::With,
    beside::Beside,
    drive::Journey,
    finish::{Found, at},
    list::Listed,
    milestone::milestone,
    result::{End, Milestone},
};
use crate::{
    diagnose::{
        Case, Cause, Diagnosis, FAINT, Monitor, Settings, Verdict, diagnose, follows_anything,
        is_a_pair,
    },
    fit::FitError,
    shrink::gap,
};

/// Most rounds of going on and looking back …
const ROUNDS: usize = 3;
/// … and most diagnoses on the way, each of which takes as long as the first one without its pairs.
const DIAGNOSES: usize = 16;

/// Causes as long as evidence asks for more. `None` where one cause or two are all there is to say.
pub(super) fn by_evidence(
    journey: &Journey<'_>,
    monitor: &dyn Monitor,
) -> Result<Option<Found>, FitError> {
    let Journey { first, settings, lists, .. } = *journey;
    let is_single = matches!(first.verdict, Verdict::Cause | Verdict::Tied);
    let Some(leader) = first.causes.first() else { return Ok(None) };
    let is_law = |cause: &Cause| lists.candidate(&[], cause).is_some_and(|c| !follows_anything(&c));
    if is_single && is_law(leader) {
        return Ok(None);
    }
    let Some(list) = lists.of(beginning(journey)) else { return Ok(None) };
    // One cause at a time: two would take as long as all the rest.
    let settings = Settings { two: 0.0, ..settings.clone() };
    let journey_of_singles = Journey { settings: &settings, ..*journey };
    let all = lists.beside(&[]).alone().into_iter().flatten();
    let curves = all.filter(follows_anything).map(|candidate| candidate.label).collect();
    let left = Cell::new(DIAGNOSES);
    let growth = Growth { journey: journey_of_singles, monitor, curves, left };
    let (list, end) = growth.grown(list)?;
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
    Ok(Some(Found { list, gaps, end }))
}

/// The causes of a list that nothing beside the same others explains clearly better: a law that a curve without a law
/// beats by far has stood for something else.
fn credible(journey: &Journey<'_>, list: Vec<Listed>, end: End) -> (Vec<Listed>, End) {
    let least = 1.0 / journey.settings.bayes_factor;
    let is_credible = |listed: &&Listed| least <= listed.milestone.odds;
    if list.iter().filter(is_credible).count() == list.len() {
        return (list, end);
    }
    let kept = list.iter().filter(is_credible).map(|listed| listed.milestone.clone());
    (journey.lists.of(kept).unwrap_or_default(), End::NothingHelps)
}

/// A list in the order of the evidence of each beside all others.
fn largest_first(journey: &Journey<'_>, list: Vec<Listed>) -> Vec<Listed> {
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
fn beginning(journey: &Journey<'_>) -> Vec<Milestone> {
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
fn gaps(journey: &Journey<'_>, list: &[Listed]) -> Result<Vec<f64>, FitError> {
    let Some(judge) = journey.judge() else { return Ok(vec![f64::NAN; list.len() + 1]) };
    let parts = (0..=list.len()).map(|n| journey.lists.model(&list[..n]));
    let left = |model| Ok(judge.refitted(model)?.map_or(f64::NAN, |model| gap(&model.errors)));
    parts.map(left).collect()
}

/// A list that cannot grow any more.
struct Grown {
    list: Vec<Listed>,
    end: End,
    /// The model with all of it, refitted together.
    fitted: Model,
}

/// A list that grows.
struct Growth<'a> {
    journey: Journey<'a>,
    monitor: &'a dyn Monitor,
    /// Labels of what follows anything.
    curves: Vec<&'static str>,
    /// Diagnoses that can still be made.
    left: Cell<usize>,
}

impl Growth<'_> {
    /// The list with what else is found, after it does not change any more.
    fn grown(&self, list: Vec<Listed>) -> Result<(Vec<Listed>, End), FitError> {
        let mut grown = self.onwards(list)?;
        for _ in 0..ROUNDS {
            let Grown { list, end, fitted } = grown;
            let before = list.len();
            let (list, is_changed) = self.looked_back(list, &fitted)?;
            if !is_changed && before == list.len() {
                return Ok((list, end));
            }
            grown = self.onwards(list)?;
        }
        Ok((grown.list, grown.end))
    }

    /// Goes on while a law has evidence.
    fn onwards(&self, mut list: Vec<Listed>) -> Result<Grown, FitError> {
        loop {
            let diagnosis = self.diagnosed(&list, None)?;
            let next = self.next(&diagnosis, &list)?.filter(|_| self.goes_on());
            let is_noise = diagnosis.verdict == Verdict::NoGap && !diagnosis.is_unexplained;
            let end = match next {
                Some(next) if list.len() < self.journey.most => {
                    list = self.with(list, next);
                    continue;
                }
                Some(_) => End::Enough,
                None if is_noise => End::AtTheNoise,
                None => End::NothingHelps,
            };
            let fitted = diagnosis.refit.model;
            let list = self.journey.lists.settled(&list, &fitted).unwrap_or(list);
            return Ok(Grown { list, end, fitted });
        }
    }

    /// Each cause is sought anew beside all others: what is not missed goes, what explains clearly more takes its place.
    fn looked_back(
        &self,
        mut list: Vec<Listed>,
        fitted: &Model,
    ) -> Result<(Vec<Listed>, bool), FitError> {
        let lists = self.journey.lists;
        let mut is_changed = false;
        let mut i = 0;
        // The last one was sought beside all others.
        while i + usize::from(!is_changed) < list.len() && self.goes_on() {
            let others = list.iter().enumerate().filter(|(j, _)| *j != i);
            let others = others.map(|(_, listed)| listed.milestone.clone());
            let others = lists.of(others).filter(|others| !others.is_empty());
            let Some(others) = others else {
                i += 1;
                continue;
            };
            let diagnosis = self.diagnosed(&others, Some(fitted))?;
            let old = &list[i];
            let same = diagnosis.causes.iter().find(|c| c.identity() == old.candidate.identity());
            let worth = same.map_or(f64::NEG_INFINITY, |same| same.log_evidence);
            let rival = self.next(&diagnosis, &others)?.filter(|next| {
                let margin = self.journey.settings.bayes_factor.ln();
                worth + margin < next.milestone.cause.log_evidence
            });
            match (same, rival) {
                (_, Some(rival)) => {
                    is_changed = true;
                    list = self.with(others, rival);
                }
                (Some(same), None)
                    if diagnosis.verdict != Verdict::NoGap
                        && self.is_worth_it(&diagnosis, same) =>
                {
                    // Its place is the same, its strength and its probability are those beside all others.
                    list[i].milestone = self.milestone(&diagnosis, same);
                    i += 1;
                }
                _ => {
                    is_changed = true;
                    list = others;
                }
            }
        }
        Ok((list, is_changed))
    }

    /// Whether a cause has evidence beside a list, and a strength: its own errors do not cover it, or held-out forecasts
    /// clearly show it.
    fn is_worth_it(&self, diagnosis: &Diagnosis, cause: &Cause) -> bool {
        let closed = at(diagnosis, self.journey.horizon).and_then(|h| h.closed_of_refit);
        let is_shown = closed.is_some_and(|closed| 0.0 < closed.interval[0]);
        let is_faint = cause.significance().is_some_and(|errors| errors < FAINT);
        is_a_pair(cause.log_evidence, 0.0) && (is_shown || !is_faint)
    }

    /// A cause with what a diagnosis says of it, its probability among laws: a curve at the same place is no other
    /// answer to which of them it is.
    fn milestone(&self, diagnosis: &Diagnosis, cause: &Cause) -> Milestone {
        let milestone = milestone(diagnosis, cause, self.journey.horizon);
        let is_curve = |cause: &&Cause| self.curves.contains(&cause.label);
        let of_curves: f64 = diagnosis.causes.iter().filter(is_curve).map(|c| c.probability).sum();
        let known = 1.0 - diagnosis.no_gap - diagnosis.none_of_these;
        let laws = ((known - of_curves) / known).max(milestone.probability);
        let probability = if 0.0 < laws { milestone.probability / laws } else { 0.0 };
        Milestone { probability, ..milestone }
    }

    /// A list with one more cause, all of it as it was fitted together.
    fn with(&self, list: Vec<Listed>, next: Listed) -> Vec<Listed> {
        let lists = self.journey.lists;
        let settled = lists.settled(&list, &next.milestone.cause.model);
        let settled = settled.and_then(|mut settled| {
            let next = lists.listed(&settled, next.milestone.clone())?;
            settled.push(next);
            Some(settled)
        });
        settled.unwrap_or_else(|| list.into_iter().chain([next]).collect())
    }

    /// Whether there is time for more.
    fn goes_on(&self) -> bool {
        0 < self.left.get() && !self.monitor.is_stopped()
    }

    /// The model with a list in it, diagnosed; what is in a `fitted` one starts from there as well.
    fn diagnosed(&self, list: &[Listed], fitted: Option<&Model>) -> Result<Diagnosis, FitError> {
        self.left.set(self.left.get().saturating_sub(1));
        let Journey { case, settings, lists, .. } = self.journey;
        let nominal = With { nominal: case.nominal, model: lists.model(list).clone() };
        let suspects = Beside { fitted, ..lists.beside(list) };
        diagnose(&Case { nominal: &nominal, suspects: &suspects, ..*case }, settings, self.monitor)
    }

    /// The law with the most evidence beside a list, if it is worth a place, and if held-out forecasts do not get worse.
    fn next(&self, diagnosis: &Diagnosis, list: &[Listed]) -> Result<Option<Listed>, FitError> {
        let lists = self.journey.lists;
        if diagnosis.verdict == Verdict::NoGap {
            return Ok(None);
        }
        let worth_it = diagnosis.causes.iter().filter(|cause| self.is_worth_it(diagnosis, cause));
        let next = worth_it
            .filter_map(|cause| lists.listed(list, self.milestone(diagnosis, cause)))
            .find(|listed| !follows_anything(&listed.candidate));
        let Some(next) = next else { return Ok(None) };
        Ok(if self.contradicts(diagnosis, list, &next)? { None } else { Some(next) })
    }

    /// Whether held-out forecasts get clearly worse with a cause. Those of a diagnosis are of its best answer, which may
    /// be a curve that goes on as it likes.
    fn contradicts(
        &self,
        diagnosis: &Diagnosis,
        list: &[Listed],
        next: &Listed,
    ) -> Result<bool, FitError> {
        let is_worse = next.milestone.closed.is_some_and(|closed| closed.interval[1] < 0.0);
        let is_best = diagnosis.causes.first().is_some_and(|best| {
            best.identity() == next.candidate.identity() && diagnosis.verdict != Verdict::Pair
        });
        let Some(judge) = self.journey.judge().filter(|_| is_worse && !is_best) else {
            return Ok(is_worse);
        };
        let before = judge.refitted(self.journey.lists.model(list))?;
        let after = judge.refitted(&next.candidate.model)?;
        Ok(!judge.is_missed(before.as_ref(), after.as_ref()))
    }
}
