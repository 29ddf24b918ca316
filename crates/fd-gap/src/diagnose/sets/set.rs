//! Several effects in one fit.

use std::sync::Arc;

use fd_effect::{Candidate, Offers, Suspects, map::mechanism};
use fd_sim::model::Model;

use crate::{
    diagnose::{
        candidates::{follows_anything, is_same_cause},
        context::Context,
        prepare::{noise::KnownNoise, step::with_step},
        result::{Cause, Pair},
        search::{
            step_size::{MOST_HALVINGS, shorter_step},
            trial::Trial,
        },
        weigh::{
            answer::{Answer, Fit},
            explain::settle,
            rank::{Reference, estimates},
            singles::Singles,
        },
    },
    evidence::{Likelihood, evidence, likelihood},
    fit::{LeastSquares, Minimum, Problem, Variable, minimise},
    shrink::gap,
};

/// Effects that were fitted together.
#[derive(Clone, Debug)]
pub struct EffectSet {
    /// The effects, each in the model that has those before it.
    pub members: Vec<Candidate>,
    /// The model with all of them; its parameters are not settled.
    pub(in crate::diagnose) model: Model,
    pub(in crate::diagnose) fit: Fit,
    /// Logarithm of the evidence over that of "no gap".
    pub log_evidence: f64,
    /// Root mean square of the training residual, in sigma.
    pub gap: f64,
    /// Size of the noise in the fit, in sigma.
    scale: f64,
}

/// A member with the values that its parameters have.
#[derive(Clone, Debug)]
pub(in crate::diagnose) struct Member<'a> {
    pub candidate: &'a Candidate,
    pub values: Vec<f64>,
}

impl EffectSet {
    /// A fit of a problem with these members; `None` when it has no evidence.
    fn of(
        members: Vec<Candidate>,
        model: Model,
        mut problem: Problem,
        minimum: Minimum,
        reference: &Reference,
    ) -> Option<Self> {
        let errors = problem.errors(&minimum.z)?;
        let likelihood = likelihood(&errors, &reference.noise);
        let scale = likelihood.scale.iter().copied().fold(0.0, f64::max);
        let gap = gap(&errors);
        let fit = Fit { problem, minimum };
        let set = Self { members, model, fit, log_evidence: 0.0, gap, scale };
        let log_evidence = set.evidence(&likelihood)? - reference.log_evidence;
        Some(Self { log_evidence, ..set })
    }

    /// Logarithm of its evidence with a likelihood, up to a constant of the logs.
    fn evidence(&self, likelihood: &Likelihood) -> Option<f64> {
        let strengths = |member: &Candidate| -> Vec<Option<f64>> {
            member.parameters.iter().map(|p| p.is_strength.then_some(p.neutral)).collect()
        };
        let strengths: Vec<Vec<Option<f64>>> = self.members.iter().map(strengths).collect();
        let strengths: Vec<&[Option<f64>]> = strengths.iter().map(Vec::as_slice).collect();
        evidence(&self.fit.problem, &self.fit.minimum, likelihood, &strengths)
    }

    /// As its evidence, in noise of any colour.
    pub(super) fn evidence_in_colour(&self, noise: &KnownNoise) -> Option<f64> {
        self.evidence(&likelihood(&self.errors()?, &noise.priors(true)))
    }

    /// No effect.
    pub(in crate::diagnose) fn none(singles: &Singles<'_>) -> Option<Self> {
        let null = &singles.searched.null;
        let (model, minimum) = (singles.searched.model.clone(), null.minimum.clone());
        Self::of(Vec::new(), model, null.problem.clone(), minimum, &singles.reference)
    }

    /// A single effect; `None` when it has no evidence.
    pub(in crate::diagnose) fn single(trial: &Trial<'_>, reference: &Reference) -> Option<Self> {
        let (members, problem) = (vec![trial.candidate.clone()], trial.problem.clone());
        Self::of(members, trial.model.clone(), problem, trial.best.clone()?, reference)
    }

    /// These effects with one more that was fitted beside them; `None` when that has no evidence.
    pub(in crate::diagnose) fn with(
        &self,
        more: &Trial<'_>,
        singles: &Singles<'_>,
    ) -> Option<Self> {
        let effects = [self.fit.problem.effects(), more.problem.effects()].concat();
        let null = &singles.searched.null.problem;
        let (plan, weights) = (Arc::clone(null.plan()), null.weights().clone());
        let simulator = more.problem.simulator().boxed();
        let problem = Problem::new(plan, simulator, effects, weights).ok()?;
        let members = self.members.iter().chain([more.candidate]).cloned().collect();
        Self::of(members, more.model.clone(), problem, more.best.clone()?, &singles.reference)
    }

    /// Members, one on top of the other, fitted from these values; `None` where that diverges.
    pub(in crate::diagnose) fn fitted(
        members: Vec<Candidate>,
        nuisances: &[f64],
        values: &[f64],
        singles: &Singles<'_>,
        context: &Context<'_>,
    ) -> Option<Self> {
        let null = &singles.searched.null.problem;
        let model = members.last().map_or(&singles.searched.model, |last| &last.model).clone();
        let simulator = context.case.nominal.patched(&model, null.simulator().ts()).ok()?;
        let parameters = members.iter().flat_map(|member| &member.parameters);
        let effects = parameters.map(Variable::effect).collect();
        let (plan, weights) = (Arc::clone(null.plan()), null.weights().clone());
        let mut problem = Problem::new(plan, simulator, effects, weights).ok()?;
        let place = problem.place(nuisances, values);
        let within = place.iter().zip(problem.bounds());
        let place: Vec<f64> = within.map(|(z, [low, high])| z.clamp(*low, *high)).collect();
        let search = problem.search();
        let minimum = minimise(&mut problem, &place, None, search)?;
        Self::of(members, model, problem, minimum, &singles.reference)
    }

    /// Those of its members at these places, in this order, fitted from where they are; `None` where one cannot be there
    /// without those that are missing.
    pub(in crate::diagnose) fn only(
        &self,
        places: &[usize],
        singles: &Singles<'_>,
        context: &Context<'_>,
    ) -> Option<Self> {
        let own = self.members();
        let wanted = places.iter().map(|place| self.members.get(*place));
        let wanted: Vec<&Candidate> = wanted.collect::<Option<_>>()?;
        let is_it = |i: usize, c: &Candidate| is_same_cause(c, wanted[i]) && c.law == wanted[i].law;
        let members = chained(wanted.len(), is_it, self.model.step, context)?;
        let values: Vec<f64> = places.iter().flat_map(|i| own[*i].values.clone()).collect();
        Self::fitted(members, &self.nuisances(), &values, singles, context)
    }

    /// The same with an integration step on which its outputs do not depend, fitted from where it is.
    pub(in crate::diagnose) fn in_short_steps(
        mut self,
        singles: &Singles<'_>,
        context: &Context<'_>,
    ) -> Self {
        for _ in 0..MOST_HALVINGS {
            let Fit { problem, minimum } = &self.fit;
            let step = shorter_step(context.case.nominal, &self.model, problem, minimum);
            let shorter = step.and_then(|step| {
                let members = self.members.iter().cloned();
                let members = members.map(|member| in_step(member, Some(step))).collect();
                Self::fitted(members, &self.nuisances(), &self.values(), singles, context)
            });
            match shorter {
                Some(shorter) => self = shorter,
                None => break,
            }
        }
        self
    }

    /// Its members with their values.
    pub(in crate::diagnose) fn members(&self) -> Vec<Member<'_>> {
        let mut values = self.values().into_iter();
        let mut own = |n: usize| values.by_ref().take(n).collect();
        let members = self.members.iter();
        members.map(|c| Member { candidate: c, values: own(c.parameters.len()) }).collect()
    }

    /// Values of the parameters of all members.
    fn values(&self) -> Vec<f64> {
        let Fit { problem, minimum } = &self.fit;
        problem.effect_values(&minimum.z)
    }

    /// The scaled unknowns of the plan.
    pub(in crate::diagnose) fn nuisances(&self) -> Vec<f64> {
        let Fit { problem, minimum } = &self.fit;
        problem.nuisances(&minimum.z)
    }

    /// Errors in sigma; `None` where it diverges.
    pub(in crate::diagnose) fn errors(&self) -> Option<Vec<Vec<Vec<f64>>>> {
        let Fit { problem, minimum } = &self.fit;
        problem.clone().errors_at(minimum)
    }

    /// Sum of squares, with what moved parameters cost.
    #[must_use]
    pub fn cost(&self) -> f64 {
        self.fit.minimum.cost
    }

    /// Its causes, of which each has the evidence of the whole.
    pub(crate) fn causes(&self) -> Vec<Cause> {
        let Fit { problem, minimum } = &self.fit;
        let model = settle(&self.model, problem, &minimum.z);
        let mut first = 0;
        let cause = |candidate: &Candidate| {
            let parameters = estimates(candidate, problem, minimum, self.scale, first);
            first += candidate.parameters.len();
            Cause {
                label: candidate.label,
                site: candidate.site.clone(),
                partner: candidate.partner.clone(),
                family: mechanism(candidate),
                side: candidate.side,
                probability: 0.0,
                log_evidence: self.log_evidence,
                law: candidate.law,
                parameters,
                gap: self.gap,
                model: model.clone(),
            }
        };
        self.members.iter().map(cause).collect()
    }

    /// Two causes as they are named: a law comes before what follows anything. `None` for any other number.
    pub(in crate::diagnose) fn pair(&self) -> Option<Pair> {
        let mut causes = <[Cause; 2]>::try_from(self.causes()).ok()?;
        let follows: Vec<bool> = self.members.iter().map(follows_anything).collect();
        if follows == [true, false] {
            causes.reverse();
        }
        Some(Pair { causes, probability: 0.0, log_evidence: self.log_evidence, gap: self.gap })
    }

    /// Whether both are of the same causes, in any order.
    pub(in crate::diagnose) fn is_of(&self, other: &Self) -> bool {
        self.has_as_many(other, is_same_cause)
    }

    /// Whether both are of the same causes with the same laws, in any order.
    #[must_use]
    pub fn is_same(&self, other: &Self) -> bool {
        self.has_as_many(other, |a, b| is_same_cause(a, b) && a.law == b.law)
    }

    fn has_as_many(&self, other: &Self, is_one: fn(&Candidate, &Candidate) -> bool) -> bool {
        let is_there = |member| other.members.iter().any(|of| is_one(of, member));
        self.members.len() == other.members.len() && self.members.iter().all(is_there)
    }

    /// Whether each of them is there: a strength below its standard error beside the others is none, and what the set
    /// explains more than they do is due to a rough sum of squares.
    pub(in crate::diagnose) fn are_all_there(&self) -> bool {
        self.causes().iter().all(is_there)
    }

    /// Whether one of them follows a log as it pleases: beside another cause it may stand for anything.
    pub(in crate::diagnose) fn follows_anything(&self) -> bool {
        self.members.iter().any(follows_anything)
    }

    /// The answer that it gives; `None` when it diverges.
    pub(in crate::diagnose) fn answer(&self) -> Option<Answer> {
        let Fit { problem, minimum } = &self.fit;
        Answer::of(&self.model, problem, minimum, self.members.len(), self.log_evidence)
    }
}

/// So many suspects, each on top of those before it and the one of its place by `is_it`; `None` if one cannot be there.
pub(super) fn chained(
    n: usize,
    is_it: impl Fn(usize, &Candidate) -> bool,
    step: Option<f64>,
    context: &Context<'_>,
) -> Option<Vec<Candidate>> {
    let suspects = context.case.suspects;
    (0..n).try_fold(Vec::new(), |mut members: Vec<Candidate>, i| {
        let found = offers(suspects, &members)
            .into_iter()
            .flatten()
            .find(|candidate| is_it(i, candidate))?;
        members.push(in_step(found, step));
        Some(members)
    })
}

/// What can be added to members of which each is on top of those before it.
pub(super) fn offers(suspects: &dyn Suspects, members: &[Candidate]) -> Offers {
    match members.last() {
        None => suspects.alone(),
        Some(last) => suspects.beside(last),
    }
}

/// A candidate with an integration step.
pub(super) fn in_step(candidate: Candidate, step: Option<f64>) -> Candidate {
    match step {
        Some(step) => Candidate { model: with_step(&candidate.model, step), ..candidate },
        None => candidate,
    }
}

/// Standard errors from which a strength is one.
const THERE: f64 = 1.0;

/// Whether a cause is there: strengths below their own standard errors are none.
pub(in crate::diagnose) fn is_there(cause: &Cause) -> bool {
    cause.significance().is_none_or(|ratio| THERE <= ratio)
}
