//! Evidence of all logs together, those held out among them.
//!
//! A curve over time follows any force that comes from somewhere else, and a hundred candidates
//! have a hundred chances to fit one log. A law of the wrong kind needs other values for another
//! log, or none will do; the right one does not, and what one manoeuvre cannot tell apart another
//! may. So the leading explanations are refitted to all logs, and what is believed rests on that.
//! What is reported (strengths, the patched model, forecasts) comes from the logs of the fit.

use std::sync::Arc;

use rayon::prelude::*;

use super::{
    answer::Answer, attempt::Weighing, observe::observe, pairs::Duo, prepare::KnownNoise,
    result::Leftover, search::Found, trial::Trial,
};
use crate::{
    evidence::{NoisePrior, evidence, likelihood},
    fit::{Horizon, LeastSquares, Log, Minimum, Plan, Problem, Search, minimise},
};

/// Causes that are refitted to all logs …
const CAUSES: usize = 8;
/// … and pairs.
const PAIRS: usize = 4;
/// The states at the start of the other logs come first.
const STARTS: Search =
    Search { iterations: 30, absolute: 1e-1, relative: 1e-4, frozen: 0, own_only: true };
/// Then everything: what is left is a tenth of a nat.
const EVERYTHING: Search =
    Search { iterations: 15, absolute: 1e-1, relative: 1e-5, frozen: 0, own_only: false };

/// All logs, with the nominal model refitted to them.
pub(super) struct AllLogs {
    plan: Arc<Plan>,
    base: Problem,
    refitted: Answer,
    priors: Vec<NoisePrior>,
    /// Logarithm of the evidence of "no gap": of the logs of the fit, and of all.
    references: [f64; 2],
}

impl AllLogs {
    /// `None` when there are no other logs, or the nominal model does not get through them.
    pub(super) fn of(
        found: &Found<'_>,
        weighing: &Weighing<'_>,
        held_out: &[Log],
        horizon: Horizon,
    ) -> Option<Self> {
        if held_out.is_empty() {
            return None;
        }
        let Weighing { base, refitted, priors, reference, .. } = weighing;
        let logs = base.plan().logs.iter().chain(held_out).cloned().collect();
        let plan = Arc::new(Plan::of_logs(base.simulator(), logs, horizon).ok()?);
        let (base, at) = refit(&plan, base, &found.null.minimum)?;
        let refitted = Answer::of(&refitted.explanation.model, &base, &at, 0, 0.0)?;
        let all = evidence(&base, &at, &likelihood(&refitted.errors, priors), &[])?;
        let (priors, references) = (priors.clone(), [*reference, all]);
        Some(Self { plan, base, refitted, priors, references })
    }

    /// Gives the leading causes and pairs their evidence of all logs, and orders them by it; the
    /// others stay behind them.
    pub(super) fn weigh(
        &self,
        found: &Found<'_>,
        weighing: &mut Weighing<'_>,
        duos: &mut [Duo],
        noise: &KnownNoise,
    ) {
        let Weighing { causes, observed, .. } = weighing;
        let leading = CAUSES.min(causes.len());
        let of_trial = |trial: &Trial<'_>| {
            self.change(&trial.problem, trial.best.as_ref()?, &[&trial.strengths])
        };
        let changes: Vec<Option<f64>> = causes[..leading]
            .par_iter()
            .map(|(trial, _)| trial.and_then(|trial| of_trial(&found.trials[trial])))
            .collect();
        let mut least = f64::INFINITY;
        for ((trial, cause), change) in causes.iter_mut().zip(changes) {
            cause.log_evidence = match (trial, change) {
                (Some(_), Some(change)) => cause.log_evidence + change,
                (Some(_), None) => f64::NEG_INFINITY,
                (None, _) => {
                    let candidate = observed.iter().find(|(c, _)| c.identity() == cause.identity());
                    let again = candidate.and_then(|(candidate, _)| {
                        observe(candidate, &self.refitted.errors, noise, found.is_coloured)
                    });
                    again.map_or(f64::NEG_INFINITY, |observed| observed.gain)
                }
            };
            if cause.log_evidence.is_finite() {
                least = least.min(cause.log_evidence);
            }
        }
        for (_, cause) in &mut causes[leading..] {
            cause.log_evidence = cause.log_evidence.min(least);
        }
        causes.sort_by(|(_, a), (_, b)| b.log_evidence.total_cmp(&a.log_evidence));
        self.weigh_pairs(duos);
    }

    fn weigh_pairs(&self, duos: &mut [Duo]) {
        let leading = PAIRS.min(duos.len());
        duos[..leading].par_iter_mut().for_each(|duo| {
            let change = self.change(&duo.problem, &duo.best, &duo.strengths());
            duo.pair.log_evidence += change.unwrap_or(f64::NEG_INFINITY);
        });
        let finite = duos[..leading].iter().map(|duo| duo.pair.log_evidence);
        let least = finite.filter(|e| e.is_finite()).fold(f64::INFINITY, f64::min);
        for duo in &mut duos[leading..] {
            duo.pair.log_evidence = duo.pair.log_evidence.min(least);
        }
        duos.sort_by(|a, b| b.pair.log_evidence.total_cmp(&a.pair.log_evidence));
    }

    /// By how much the other logs raise the logarithm of the evidence of a fit over that of
    /// "no gap".
    fn change(&self, problem: &Problem, at: &Minimum, strengths: &[&[Option<f64>]]) -> Option<f64> {
        let weight = |problem: &Problem, at: &Minimum| {
            let errors = problem.clone().errors(&at.z)?;
            evidence(problem, at, &likelihood(&errors, &self.priors), strengths)
        };
        let (refitted, there) = refit(&self.plan, problem, at)?;
        let [before, after] = [weight(problem, at)?, weight(&refitted, &there)?];
        Some(after - self.references[1] - (before - self.references[0]))
    }

    /// What an answer leaves of all logs; `None` when it does not get through the others.
    pub(super) fn leftover(
        &self,
        answer: &Answer,
        noise: &KnownNoise,
        is_coloured: bool,
    ) -> Option<Leftover> {
        let refitted = match &answer.fit {
            None => self.refitted.clone(),
            Some((problem, at)) => {
                let (problem, at) = refit(&self.plan, problem, at)?;
                let Answer { explanation, effects, log_evidence, .. } = answer;
                Answer::of(&explanation.model, &problem, &at, *effects, *log_evidence)?
            }
        };
        Some(refitted.rest(&self.refitted, &self.base, noise, is_coloured).leftover)
    }
}

/// A fit, carried over to all logs of a plan that begins with those of the fit.
fn refit(plan: &Arc<Plan>, problem: &Problem, at: &Minimum) -> Option<(Problem, Minimum)> {
    let simulator = problem.simulator().boxed();
    let (effects, weights) = (problem.effects().to_vec(), problem.weights().clone());
    let mut all = Problem::new(Arc::clone(plan), simulator, effects, weights).ok()?;
    let shared = problem.layout().shared;
    let known = problem.plan().own_variables().zip(&at.z[shared..]).map(|(v, z)| v.value(*z));
    let mut z = at.z[..shared].to_vec();
    z.extend(plan.own_variables().zip(known).map(|(v, value)| v.scaled(value)));
    z.resize(all.layout().unknowns(), 0.0);
    let begun = minimise(&mut all, &z, None, STARTS)?;
    let there = minimise(&mut all, &begun.z, None, EVERYTHING)?;
    Some((all, there))
}
