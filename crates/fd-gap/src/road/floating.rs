//! A set of causes that grows by evidence, each sought again beside all others.
//!
//! No set is gone back to, so that it comes to an end.

use fd_effect::Candidate;

use super::{
    result::End,
    selection::{Found, Named, Selection},
};
use crate::{
    diagnose::{Cause, EffectSet, FAINT, Settings, Wanted, follows_anything, is_a_pair},
    fit::FitError,
    shrink::{Closed, Errors, closed},
};

/// Evidence, in nats, by which what takes the place of a cause must be better: of what the log can hardly tell apart the list
/// has the likeliest, not the one that was found first. Evidence is known to about a tenth from fits that start elsewhere.
const CLEARLY: f64 = 0.1;

impl Selection<'_> {
    /// The set with what else is found, after it does not change any more; `None` where that takes too long.
    pub(super) fn grown(&self, set: EffectSet) -> Result<Option<Found>, FitError> {
        let Some((mut set, mut end)) = self.onwards(set)? else { return Ok(None) };
        let mut known = vec![set.clone()];
        while self.goes_on() {
            let (other, named) = self.looked_back(set, &mut known)?;
            if let Some(named) = named {
                return Ok(Some(Found { set: other, named, end }));
            }
            match self.onwards(other)? {
                Some(further) => (set, end) = further,
                None => return Ok(None),
            }
        }
        Ok(None)
    }

    /// Adds the law with the most evidence, as long as one is worth a place; `None` where only noise may be left, and the
    /// best law takes too little for that.
    fn onwards(&self, mut set: EffectSet) -> Result<Option<(EffectSet, End)>, FitError> {
        while self.goes_on() {
            match self.next(&set)? {
                Some(next)
                    if self.is_to_the_noise
                        && !takes_the_mean([&set, &next].map(above_the_noise), self.most) =>
                {
                    return Ok(None);
                }
                Some(next) if set.members.len() < self.most => {
                    set = self.search.in_short_steps(next);
                }
                Some(_) => return Ok(Some((set, End::Enough))),
                None if self.search.is_noise(&set) => return Ok(Some((set, End::AtTheNoise))),
                None => break,
            }
        }
        Ok(Some((set, End::NothingHelps)))
    }

    /// Whether there is time for more.
    fn goes_on(&self) -> bool {
        0 < self.looks.get() && !self.search.is_stopped()
    }

    /// The set with one more effect each, the most evidence first.
    pub(super) fn beside(
        &self,
        set: &EffectSet,
        wanted: &Wanted<'_>,
    ) -> Result<Vec<EffectSet>, FitError> {
        self.looks.set(self.looks.get().saturating_sub(1));
        self.search.beside(set, wanted)
    }

    /// The set with the law that has the most evidence of those that are worth a place, unless it forecasts worse.
    pub(super) fn next(&self, set: &EffectSet) -> Result<Option<EffectSet>, FitError> {
        let laws = |candidate: &Candidate| !follows_anything(candidate);
        let more = self.beside(set, &Wanted { candidate: &laws, least: 0.0 })?;
        let before = self.search.forecast(set)?;
        let worth_it = |more: &EffectSet| is_a_pair(self.search.gain(more, set), 0.0);
        for found in more.into_iter().filter(worth_it) {
            match self.shown(before.as_deref(), &found, set.members.len())? {
                Shown::Clearly => return Ok(Some(found)),
                Shown::Faintly => {}
                Shown::Contradicted => break,
            }
        }
        Ok(None)
    }

    /// Each cause is sought anew beside all others: what is not missed goes, what explains more takes its place, if the set
    /// is not `known` with that. Of a set that stays the same, what is said of each.
    fn looked_back(
        &self,
        mut set: EffectSet,
        known: &mut Vec<EffectSet>,
    ) -> Result<(EffectSet, Option<Vec<Named>>), FitError> {
        let (mut named, mut is_changed) = (Vec::new(), false);
        for _ in 0..set.members.len() {
            if !self.goes_on() {
                return Ok((set, None));
            }
            match self.sought_anew(&set, named.len(), known)? {
                Ok(same) => named.push(same),
                Err(other) => {
                    // What takes its place comes last, so that the next one is at the same place.
                    known.push((*other).clone());
                    (set, is_changed) = (*other, true);
                }
            }
        }
        Ok((set, (!is_changed).then_some(named)))
    }

    /// What is said of a member that is sought anew, or the set to go on with instead, which is none of the `known` ones.
    fn sought_anew(
        &self,
        set: &EffectSet,
        i: usize,
        known: &[EffectSet],
    ) -> Result<Result<Named, Box<EffectSet>>, FitError> {
        let search = self.search;
        let own = &set.members[i];
        let Some(others) = search.without(set, i) else {
            // The rest is not possible without it.
            let log_evidence = set.log_evidence;
            let only = Named { log_evidence, probability: 1.0, tied: Vec::new(), odds: 1.0 };
            return Ok(Ok(only));
        };
        let worth = search.gain(set, &others);
        // What takes less is no rival.
        let least = others.cost() - set.cost();
        let other_laws = |c: &Candidate| c.identity() != own.identity() || c.law != own.law;
        let rivals = self.beside(&others, &Wanted { candidate: &other_laws, least })?;
        let is_curve = |rival: &EffectSet| rival.members.last().is_some_and(follows_anything);
        let (curves, laws): (Vec<EffectSet>, Vec<EffectSet>) =
            rivals.into_iter().partition(is_curve);
        let before = search.forecast(&others)?;
        let better = laws.first().filter(|law| set.log_evidence + CLEARLY < law.log_evidence);
        let better = match better {
            Some(better) => {
                let shown = self.shown(before.as_deref(), better, others.members.len())?;
                (!matches!(shown, Shown::Contradicted)).then(|| better.clone())
            }
            None => None,
        };
        let other = if better.is_some() {
            better
        } else {
            let is_missed = is_a_pair(worth, 0.0)
                && matches!(self.shown(before.as_deref(), set, i)?, Shown::Clearly);
            (!is_missed && !others.members.is_empty()).then_some(others)
        };
        match other.filter(|other| !known.iter().any(|known| known.is_same(other))) {
            Some(other) => Ok(Err(Box::new(other))),
            None => Ok(Ok(self.named(set, i, worth, &laws, &curves))),
        }
    }

    /// What is said of a member, of which the rest of the evidence is known.
    fn named(
        &self,
        set: &EffectSet,
        i: usize,
        log_evidence: f64,
        laws: &[EffectSet],
        curves: &[EffectSet],
    ) -> Named {
        let own = set.members[i].identity();
        let mut rivals: Vec<&EffectSet> = Vec::new();
        for law in laws {
            let Some(last) = law.members.last().filter(|last| last.identity() != own) else {
                continue;
            };
            let is_it = |known: &&EffectSet| {
                known.members.last().is_some_and(|known| known.identity() == last.identity())
            };
            if !rivals.iter().any(is_it) {
                rivals.push(law);
            }
        }
        let evidence = std::iter::once(set).chain(rivals.iter().copied()).map(|s| s.log_evidence);
        let shares = self.search.shares(&evidence.collect::<Vec<f64>>());
        let tied: Vec<(usize, &&EffectSet)> = rivals
            .iter()
            .enumerate()
            .filter(|(_, rival)| self.search.are_tied(set, rival))
            .collect();
        let probability = shares[0] + tied.iter().map(|(place, _)| shares[place + 1]).sum::<f64>();
        let tied = tied.iter().filter_map(|(_, rival)| rival.members.last());
        let tied = tied.map(|last| last.label.to_owned()).collect();
        let others = laws.iter().chain(curves).map(|rival| rival.log_evidence);
        let best = others.fold(set.log_evidence, f64::max);
        let odds = ((set.log_evidence - best) / self.search.settings().temperature).exp();
        Named { log_evidence, probability, tied, odds }
    }

    /// How a set shows the member at a place, of which the rest forecasts with the errors `before`.
    fn shown(
        &self,
        before: Option<&Errors>,
        set: &EffectSet,
        place: usize,
    ) -> Result<Shown, FitError> {
        let after = self.search.forecast(set)?;
        let interval = self.closed(before, after.as_deref()).map(|c| c.interval);
        let significance = set.causes().get(place).and_then(Cause::significance);
        Ok(match interval {
            Some([_, high]) if high < 0.0 => Shown::Contradicted,
            Some([low, _]) if 0.0 < low => Shown::Clearly,
            _ if significance.is_some_and(|errors| errors < FAINT) => Shown::Faintly,
            _ => Shown::Clearly,
        })
    }

    /// The share of a held-out gap that is closed; `None` without held-out logs, where something diverges or no gap is left.
    pub(super) fn closed(&self, before: Option<&Errors>, after: Option<&Errors>) -> Option<Closed> {
        let Settings { replicas, seed, .. } = *self.search.settings();
        closed(before?, after?, self.floor(), replicas, seed).map(Closed::between_runs)
    }
}

/// Squares that a set leaves above the noise, in its mean square.
pub(super) fn above_the_noise(set: &EffectSet) -> f64 {
    (set.gap.powi(2) - 1.0).max(0.0)
}

/// How much speaks for a cause in a set.
enum Shown {
    /// Held-out forecasts, or a strength that its own errors do not cover.
    Clearly,
    Faintly,
    /// Held-out forecasts are clearly worse.
    Contradicted,
}

/// Whether what took squares from `before` to `after` may be the best of so many laws that leave nothing together: that one takes
/// at least the mean.
pub(super) fn takes_the_mean([before, after]: [f64; 2], of: usize) -> bool {
    after <= (1.0 - 1.0 / of as f64) * before
}
