//! Near the noise: causes as long as the likelihood asks for more, each looked at again with all others there.
//!
//! What one cause or two explain best may be no part of what three explain better: a cause that was found first has
//! stood for those that were not there yet. So each is taken out again and sought anew beside all others, until the
//! list stays as it is: coordinate ascent of the evidence over the places of the list.

use std::cell::Cell;

use fd_model::Record;

use super::{
    adjustable::With,
    drive::Journey,
    finish::Found,
    list::Listed,
    milestone::milestone,
    result::{End, Milestone},
};
use crate::{
    diagnose::{
        Case, Cause, Diagnosis, Monitor, Settings, Verdict, diagnose, follows_anything, is_a_pair,
        is_free_curve,
    },
    fit::FitError,
    shrink::gap,
};

/// Most rounds of going on and looking back …
const ROUNDS: usize = 3;
/// … and most diagnoses on the way, each of which takes as long as the first one without its pairs.
const DIAGNOSES: usize = 24;

/// Causes as long as evidence asks for more. `None` where one cause or two are all there is to say.
pub(super) fn by_evidence(
    journey: &Journey<'_>,
    monitor: &dyn Monitor,
) -> Result<Option<Found>, FitError> {
    let Journey { first, settings, lists, .. } = *journey;
    let is_single = matches!(first.verdict, Verdict::Cause | Verdict::Tied);
    let Some(leader) = first.causes.first() else { return Ok(None) };
    let is_law = |cause: &Cause| lists.candidate(&[], cause).is_some_and(|c| !is_free_curve(&c));
    if is_single && is_law(leader) {
        return Ok(None);
    }
    let Some(list) = lists.of(beginning(journey)) else { return Ok(None) };
    // One cause at a time: two would take as long as all the rest.
    let settings = Settings { two: 0.0, ..settings.clone() };
    let journey_of_singles = Journey { settings: &settings, ..*journey };
    let growth = Growth { journey: journey_of_singles, monitor, left: Cell::new(DIAGNOSES) };
    let (list, end) = growth.grown(list)?;
    let is_news = match first.verdict {
        Verdict::Pair => 2 < list.len(),
        // Laws that explain clearly more than a curve, which draws itself …
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

/// Log-likelihood that a list gains over a cause: `n ln` of what the two leave, root mean square.
fn gained(journey: &Journey<'_>, list: &[Listed], over: &Cause) -> f64 {
    let left = list.last().map_or(f64::INFINITY, |last| last.milestone.cause.gap);
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
            let of_pair = |cause: &Cause| Cause { probability: pair.probability, ..cause.clone() };
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

/// A list that grows.
struct Growth<'a> {
    journey: Journey<'a>,
    monitor: &'a dyn Monitor,
    /// Diagnoses that can still be made.
    left: Cell<usize>,
}

impl Growth<'_> {
    /// The list with what else is found, after it does not change any more.
    fn grown(&self, list: Vec<Listed>) -> Result<(Vec<Listed>, End), FitError> {
        let mut grown = self.onwards(list)?;
        for _ in 0..ROUNDS {
            let before = grown.0.len();
            let (list, is_changed) = self.looked_back(grown.0)?;
            if !is_changed && before == list.len() {
                return Ok((list, grown.1));
            }
            grown = self.onwards(list)?;
        }
        Ok(grown)
    }

    /// Goes on while a law has evidence.
    fn onwards(&self, mut list: Vec<Listed>) -> Result<(Vec<Listed>, End), FitError> {
        loop {
            let diagnosis = self.diagnosed(&list)?;
            let Some(next) = self.next(&diagnosis, &list).filter(|_| self.goes_on()) else {
                let is_noise = diagnosis.verdict == Verdict::NoGap && !diagnosis.is_unexplained;
                return Ok((list, if is_noise { End::AtTheNoise } else { End::NothingHelps }));
            };
            if list.len() == self.journey.most {
                return Ok((list, End::Enough));
            }
            list.push(next);
        }
    }

    /// Each cause is sought anew beside all others: what is not missed goes, what explains clearly more takes its place.
    fn looked_back(&self, mut list: Vec<Listed>) -> Result<(Vec<Listed>, bool), FitError> {
        let lists = self.journey.lists;
        let mut is_changed = false;
        let mut i = 0;
        // The last one was sought beside all others.
        while i + usize::from(!is_changed) < list.len() && self.goes_on() {
            let others = list.iter().enumerate().filter(|(j, _)| *j != i);
            let others = others.map(|(_, listed)| listed.milestone.clone());
            let others = lists.of(others).filter(|others| !others.is_empty());
            let Some(mut others) = others else {
                i += 1;
                continue;
            };
            let diagnosis = self.diagnosed(&others)?;
            let old = &list[i];
            let same = diagnosis.causes.iter().find(|c| c.identity() == old.candidate.identity());
            let worth = same.map_or(f64::NEG_INFINITY, |same| same.log_evidence);
            let rival = self.next(&diagnosis, &others).filter(|next| {
                let margin = self.journey.settings.bayes_factor.ln();
                worth + margin < next.milestone.cause.log_evidence
            });
            match (same, rival) {
                (_, Some(rival)) => {
                    is_changed = true;
                    others.push(rival);
                    list = others;
                }
                (Some(same), None) if diagnosis.verdict != Verdict::NoGap => {
                    // Its place is the same, its strength and its probability are those beside all others.
                    list[i].milestone = milestone(&diagnosis, same, self.journey.horizon);
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

    /// Whether there is time for more.
    fn goes_on(&self) -> bool {
        0 < self.left.get() && !self.monitor.is_stopped()
    }

    /// The model with a list in it, diagnosed.
    fn diagnosed(&self, list: &[Listed]) -> Result<Diagnosis, FitError> {
        self.left.set(self.left.get().saturating_sub(1));
        let Journey { case, settings, lists, .. } = self.journey;
        let nominal = With { nominal: case.nominal, model: lists.model(list).clone() };
        let suspects = lists.beside(list);
        diagnose(&Case { nominal: &nominal, suspects: &suspects, ..*case }, settings, self.monitor)
    }

    /// The law with the most evidence beside a list, if it is worth a place, and if held-out forecasts do not get worse.
    fn next(&self, diagnosis: &Diagnosis, list: &[Listed]) -> Option<Listed> {
        let Journey { lists, horizon, .. } = self.journey;
        if diagnosis.verdict == Verdict::NoGap {
            return None;
        }
        let worth_it = diagnosis.causes.iter().filter(|cause| is_a_pair(cause.log_evidence, 0.0));
        let next = worth_it
            .filter_map(|cause| lists.listed(list, milestone(diagnosis, cause, horizon)))
            .find(|listed| !follows_anything(&listed.candidate))?;
        let is_worse = next.milestone.closed.is_some_and(|closed| closed.interval[1] < 0.0);
        (!is_worse).then_some(next)
    }
}
