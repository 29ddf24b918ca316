//! Two causes that were fitted together.

use std::sync::Arc;

use fd_effect::{Candidate, map::mechanism};
use fd_sim::model::Model;

use super::{
    answer::{Answer, Fit, PAIR, Proposal},
    explain::settle,
    rank::{Reference, estimates},
};
use crate::{
    diagnose::{
        candidates::{follows_anything, is_same_cause},
        result::{Cause, Pair},
        search::trial::Trial,
    },
    evidence::{evidence, likelihood},
    fit::{NullFit, Problem},
    shrink::gap,
};

/// Standard errors from which a strength is one.
const THERE: f64 = 1.0;

/// Two causes, fitted together.
#[derive(Clone, Debug)]
pub(in crate::diagnose) struct FittedPair {
    /// Evidence is over that of "no gap".
    pub(in crate::diagnose) pair: Pair,
    /// The model with both; its parameters are not settled.
    model: Model,
    pub(in crate::diagnose) fit: Fit,
    members: [Candidate; 2],
}

/// A cause of a pair, with the values that its parameters have there.
#[derive(Clone, Debug)]
pub(super) struct Member<'a> {
    pub(super) candidate: &'a Candidate,
    pub(super) values: Vec<f64>,
    /// Those of the pair.
    pub(super) nuisances: Vec<f64>,
}

impl FittedPair {
    /// A `second` cause that was fitted beside a first one; `None` when it has no evidence.
    pub(super) fn of(
        first: &Trial<'_>,
        second: &Trial<'_>,
        null: &NullFit,
        reference: &Reference,
    ) -> Option<Self> {
        let best = second.best.clone()?;
        let effects = [first.problem.effects(), second.problem.effects()].concat();
        let simulator = second.problem.simulator().boxed();
        let weights = null.problem.weights().clone();
        let plan = Arc::clone(null.problem.plan());
        let mut problem = Problem::new(plan, simulator, effects, weights).ok()?;
        let errors = problem.errors(&best.z)?;
        let likelihood = likelihood(&errors, &reference.noise);
        let scale = likelihood.scale.iter().copied().fold(0.0, f64::max);
        let strengths: [&[_]; 2] = [&first.strengths, &second.strengths];
        let log_evidence =
            evidence(&problem, &best, &likelihood, &strengths)? - reference.log_evidence;
        let gap = gap(&errors);
        let model = settle(&second.model, &problem, &best.z);
        let members = [first.candidate.clone(), second.candidate.clone()];
        let cause = |which: usize, from: usize| {
            let candidate = &members[which];
            Cause {
                label: candidate.label,
                site: candidate.site.clone(),
                partner: candidate.partner.clone(),
                family: mechanism(candidate),
                side: candidate.side,
                probability: 0.0,
                log_evidence,
                law: candidate.law,
                parameters: estimates(candidate, &problem, &best, scale, from),
                gap,
                model: model.clone(),
            }
        };
        let causes = [cause(0, 0), cause(1, first.strengths.len())];
        let pair = Pair { causes, probability: 0.0, log_evidence, gap };
        let fit = Fit { problem, minimum: best };
        Some(Self { pair, model: second.model.clone(), fit, members })
    }

    /// The pair as it is named: a law comes before what follows anything.
    pub(in crate::diagnose) fn named(&self) -> Pair {
        let mut pair = self.pair.clone();
        let [first, second] = self.members.each_ref().map(follows_anything);
        if first && !second {
            pair.causes.reverse();
        }
        pair
    }

    /// Whether both are of the same two causes, in any order.
    pub(super) fn is_of(&self, other: &Self) -> bool {
        let [a, b] = &self.members;
        let [c, d] = &other.members;
        is_same_cause(a, c) && is_same_cause(b, d) || is_same_cause(a, d) && is_same_cause(b, c)
    }

    /// Whether each of them is there: a strength below its standard error beside the other cause is none, and
    /// what the pair explains more than the other alone is due to a rough sum of squares.
    pub(super) fn are_both_there(&self) -> bool {
        let is_there = |cause: &Cause| cause.significance().is_none_or(|ratio| THERE <= ratio);
        self.pair.causes.iter().all(is_there)
    }

    /// Whether one of them follows a log as it pleases: beside another cause it may stand for anything.
    pub(in crate::diagnose) fn follows_anything(&self) -> bool {
        self.members.iter().any(follows_anything)
    }

    /// Both causes.
    pub(super) fn members(&self) -> [Member<'_>; 2] {
        let [first, second] = &self.members;
        let Fit { problem, minimum } = &self.fit;
        let mut values = problem.effect_values(&minimum.z);
        let of_second = values.split_off(first.parameters.len());
        let nuisances = problem.nuisances(&minimum.z);
        let member = |candidate, values| Member { candidate, values, nuisances: nuisances.clone() };
        [member(first, values), member(second, of_second)]
    }

    /// The answer that it gives; `None` when it diverges.
    pub(super) fn answer(&self) -> Option<Answer> {
        let Fit { problem, minimum } = &self.fit;
        Answer::of(&self.model, problem, minimum, 2, self.pair.log_evidence)
    }

    /// That answer, if it is so much better than a single cause that two are worth their name.
    pub(super) fn proposal(&self) -> Option<Proposal> {
        self.answer().map(|answer| Proposal { answer, price: PAIR })
    }
}
