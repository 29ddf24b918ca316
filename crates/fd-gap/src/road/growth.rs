//! A list of causes that grows by evidence, each looked at again with all others there.

use std::cell::Cell;

use fd_effect::Suspects;
use fd_sim::model::Model;

use super::{
    drive::Journey,
    finish::at,
    list::Listed,
    milestone::milestone,
    result::{End, Milestone},
};
use crate::{
    diagnose::{
        Cause, Diagnosis, FAINT, Monitor, Regime, Settings, Verdict, diagnose, follows_anything,
        is_a_pair,
    },
    fit::FitError,
};

/// Most diagnoses on the way.
const DIAGNOSES: usize = 16;
/// Evidence, in nats, by which what takes the place of a cause must be better: of what the log can hardly tell apart the list
/// has the likeliest, not the one that was found first. Evidence is known to about a tenth from fits that start elsewhere.
const CLEARLY: f64 = 0.1;
/// Most rounds of going on and looking back.
const ROUNDS: usize = 3;

/// A list that cannot grow any more.
pub(super) struct Grown {
    pub(super) list: Vec<Listed>,
    pub(super) end: End,
    /// The model with all of it, refitted together.
    fitted: Model,
}

/// A list that grows.
pub(super) struct Growth<'a> {
    journey: Journey<'a>,
    monitor: &'a dyn Monitor,
    /// Labels of what follows anything.
    curves: Vec<&'static str>,
    /// Diagnoses that can still be made.
    left: Cell<usize>,
    /// Whether the last cause of a list was sought beside all others.
    is_last_sought: Cell<bool>,
}

impl<'a> Growth<'a> {
    /// On a journey of which the `settings` are those for one law at a time.
    pub(super) fn new(
        journey: &Journey<'a>,
        settings: &'a Settings,
        monitor: &'a dyn Monitor,
    ) -> Self {
        let all = journey.lists.beside(&[]).alone().into_iter().flatten();
        let curves = all.filter(follows_anything).map(|candidate| candidate.label).collect();
        let journey = Journey { settings, ..*journey };
        let (left, is_last_sought) = (Cell::new(DIAGNOSES), Cell::new(true));
        Self { journey, monitor, curves, left, is_last_sought }
    }

    /// As [`grown`](Self::grown), from a list that was only glimpsed; `None` where a whole diagnosis beside it is far above
    /// the noise.
    pub(super) fn grown_near(
        &self,
        list: Vec<Listed>,
    ) -> Result<Option<(Vec<Listed>, End)>, FitError> {
        self.is_last_sought.set(false);
        let beside = self.diagnosed(&list, None)?;
        match beside.regime {
            Regime::AtTheFloor => self.grown(list, Some(beside)).map(Some),
            Regime::AboveTheFloor => Ok(None),
        }
    }

    /// The list with what else is found, after it does not change any more; the diagnosis `beside` it may be known.
    pub(super) fn grown(
        &self,
        list: Vec<Listed>,
        beside: Option<Diagnosis>,
    ) -> Result<(Vec<Listed>, End), FitError> {
        let mut grown = self.onwards(list, beside)?;
        for _ in 0..ROUNDS {
            let Grown { list, end, fitted, .. } = grown;
            let before = list.len();
            let (list, is_changed) = self.looked_back(list, &fitted)?;
            if !is_changed && before == list.len() {
                return Ok((list, end));
            }
            grown = self.onwards(list, None)?;
        }
        Ok((grown.list, grown.end))
    }

    /// Goes on while a law has evidence. Before one that a curve beats by far, what is there is looked at again: the
    /// curve may draw what something on the list stands for wrongly.
    fn onwards(
        &self,
        mut list: Vec<Listed>,
        mut beside: Option<Diagnosis>,
    ) -> Result<Grown, FitError> {
        let mut is_looked_at = false;
        loop {
            let diagnosis = match beside.take() {
                Some(diagnosis) => diagnosis,
                None => self.diagnosed(&list, None)?,
            };
            let next = self.next(&diagnosis, &list)?.filter(|_| self.goes_on());
            let is_noise = is_noise(&diagnosis);
            let end = match next {
                Some(next) if list.len() < self.journey.most => {
                    if !is_looked_at && !next.is_credible(self.journey.settings) {
                        let (again, is_changed) = self.looked_back(list, &diagnosis.refit.model)?;
                        list = again;
                        is_looked_at = true;
                        if is_changed {
                            continue;
                        }
                    }
                    is_looked_at = false;
                    list = self.journey.lists.with(list, next);
                    self.is_last_sought.set(true);
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

    /// Each cause is sought anew beside all others: what is not missed goes, what explains more takes its place.
    fn looked_back(
        &self,
        mut list: Vec<Listed>,
        fitted: &Model,
    ) -> Result<(Vec<Listed>, bool), FitError> {
        let lists = self.journey.lists;
        let mut is_changed = false;
        let mut i = 0;
        while self.goes_on() {
            let is_sought = !is_changed && self.is_last_sought.get();
            if list.len() <= i + usize::from(is_sought) {
                break;
            }
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
            let rival = self
                .next(&diagnosis, &others)?
                .filter(|next| worth + CLEARLY < next.milestone.cause.log_evidence);
            match (same, rival) {
                (_, Some(rival)) => {
                    is_changed = true;
                    list = lists.with(others, rival);
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
        self.is_last_sought.set(true);
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

    /// Whether there is time for more.
    fn goes_on(&self) -> bool {
        0 < self.left.get() && !self.monitor.is_stopped()
    }

    /// The model with a list in it, diagnosed; what is in a `fitted` one starts from there as well.
    fn diagnosed(&self, list: &[Listed], fitted: Option<&Model>) -> Result<Diagnosis, FitError> {
        self.left.set(self.left.get().saturating_sub(1));
        let settings = self.journey.settings;
        self.journey.beside(list, fitted, |case| diagnose(case, settings, self.monitor))
    }

    /// The law with the most evidence beside a list, if it is worth a place, and if held-out forecasts do not get worse.
    fn next(&self, diagnosis: &Diagnosis, list: &[Listed]) -> Result<Option<Listed>, FitError> {
        let lists = self.journey.lists;
        if diagnosis.verdict == Verdict::NoGap {
            return Ok(None);
        }
        let worth_it = diagnosis.causes.iter().filter(|cause| self.is_worth_it(diagnosis, cause));
        let mut laws = worth_it
            .filter_map(|cause| lists.listed(list, self.milestone(diagnosis, cause)))
            .filter(|listed| !follows_anything(&listed.candidate));
        match laws.next() {
            Some(next) if !self.contradicts(diagnosis, list, &next)? => Ok(Some(next)),
            _ => Ok(None),
        }
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

/// Whether nothing is left but noise, and what no cause explains better than chance.
fn is_noise(diagnosis: &Diagnosis) -> bool {
    let is_evident = |cause: &Cause| is_a_pair(cause.log_evidence, 0.0);
    let is_silent =
        diagnosis.regime == Regime::AtTheFloor && !diagnosis.causes.iter().any(is_evident);
    !diagnosis.is_unexplained && (diagnosis.verdict == Verdict::NoGap || is_silent)
}
