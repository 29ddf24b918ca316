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
    answer::Answer,
    attempt::Weighing,
    observe::observe,
    pairs::Duo,
    prepare::KnownNoise,
    rank::{Yardstick, is_same},
    result::Leftover,
    search::Found,
    trial::Trial,
};
use crate::{
    evidence::{NoisePrior, evidence, likelihood, pool},
    fit::{Horizon, LeastSquares, Log, Minimum, Plan, Problem, Search, minimise},
};

/// Causes that are refitted to all logs …
const CAUSES: usize = 8;
/// … and pairs.
const PAIRS: usize = 4;
/// Laws of a cause are refitted when the logs of the fit leave them so near to the best of them.
const NEAR: f64 = 10.0;
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

/// A law of a cause.
struct Law {
    /// Place among the trials.
    trial: usize,
    /// Logarithm of the evidence over that of "no gap": of the logs of the fit, and of all.
    evidence: [f64; 2],
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
        found: &mut Found<'_>,
        weighing: &mut Weighing<'_>,
        duos: &mut [Duo],
        noise: &KnownNoise,
    ) {
        let Weighing { causes, observed, priors, reference, .. } = weighing;
        let leading = CAUSES.min(causes.len());
        let (leading, others) = causes.split_at_mut(leading);
        let trials = &found.trials;
        let of_trial = |trial: &usize| self.laws(trials, &trials[*trial]);
        let laws: Vec<Option<Vec<Law>>> =
            leading.par_iter().map(|(trial, _)| trial.as_ref().map(of_trial)).collect();
        for ((trial, cause), laws) in leading.iter_mut().zip(laws) {
            let Some(laws) = laws else {
                let candidate = observed.iter().find(|(c, _)| c.identity() == cause.identity());
                let again = candidate.and_then(|(candidate, _)| {
                    observe(candidate, &self.refitted.errors, noise, found.is_coloured)
                });
                cause.log_evidence = again.map_or(f64::NEG_INFINITY, |observed| observed.gain);
                continue;
            };
            let pooled =
                |which: usize| pool(&laws.iter().map(|l| l.evidence[which]).collect::<Vec<_>>());
            let log_evidence = cause.log_evidence + pooled(1) - pooled(0);
            let best = laws.iter().max_by(|a, b| a.evidence[1].total_cmp(&b.evidence[1]));
            if let Some(best) = best.filter(|best| Some(best.trial) != *trial) {
                let yardstick = Yardstick { noise: priors, reference: *reference };
                *cause = found.trials[best.trial].weigh(best.trial, yardstick).cause;
                *trial = Some(best.trial);
            }
            cause.log_evidence = log_evidence;
        }
        let evidence = leading.iter().map(|(_, cause)| cause.log_evidence);
        let least = evidence.filter(|e| e.is_finite()).fold(f64::INFINITY, f64::min);
        for (_, cause) in others {
            cause.log_evidence = cause.log_evidence.min(least);
        }
        causes.sort_by(|(_, a), (_, b)| b.log_evidence.total_cmp(&a.log_evidence));
        self.weigh_pairs(duos);
    }

    /// The laws of the cause of a trial that come near the best of them, in both kinds of evidence.
    fn laws(&self, trials: &[Trial<'_>], first: &Trial<'_>) -> Vec<Law> {
        let of_cause = trials.iter().enumerate().filter(|(_, trial)| {
            std::ptr::eq(*trial, first)
                || trial.is_final && is_same(trial.candidate, first.candidate)
        });
        let fitted: Vec<(usize, &Trial<'_>, &Minimum, f64)> = of_cause
            .filter_map(|(i, trial)| {
                let best = trial.best.as_ref()?;
                let before = self.evidence(0, &trial.problem, best, &[&trial.strengths])?;
                Some((i, trial, best, before))
            })
            .collect();
        let most = fitted.iter().map(|law| law.3).fold(f64::NEG_INFINITY, f64::max);
        let near = fitted.into_iter().filter(|law| most - NEAR < law.3);
        let weighed = near.map(|(trial, fit, best, before)| {
            let after = self.with_others(&fit.problem, best, &[&fit.strengths]);
            Law { trial, evidence: [before, after.unwrap_or(f64::NEG_INFINITY)] }
        });
        weighed.collect()
    }

    fn weigh_pairs(&self, duos: &mut [Duo]) {
        let leading = PAIRS.min(duos.len());
        let (leading, others) = duos.split_at_mut(leading);
        leading.par_iter_mut().for_each(|duo| {
            let after = self.with_others(&duo.problem, &duo.best, &duo.strengths());
            duo.pair.log_evidence = after.unwrap_or(f64::NEG_INFINITY);
        });
        let evidence = leading.iter().map(|duo| duo.pair.log_evidence);
        let least = evidence.filter(|e| e.is_finite()).fold(f64::INFINITY, f64::min);
        for duo in others {
            duo.pair.log_evidence = duo.pair.log_evidence.min(least);
        }
        duos.sort_by(|a, b| b.pair.log_evidence.total_cmp(&a.pair.log_evidence));
    }

    /// Logarithm of the evidence of all logs over that of "no gap".
    fn with_others(
        &self,
        problem: &Problem,
        at: &Minimum,
        strengths: &[&[Option<f64>]],
    ) -> Option<f64> {
        let (problem, at) = refit(&self.plan, problem, at)?;
        self.evidence(1, &problem, &at, strengths)
    }

    /// Logarithm of the evidence of the logs of the fit (0) or of all (1) over that of "no gap".
    fn evidence(
        &self,
        which: usize,
        problem: &Problem,
        at: &Minimum,
        strengths: &[&[Option<f64>]],
    ) -> Option<f64> {
        let errors = problem.clone().errors(&at.z)?;
        let found = evidence(problem, at, &likelihood(&errors, &self.priors), strengths)?;
        Some(found - self.references[which])
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
