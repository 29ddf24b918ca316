//! From a judgement to the result: the answer that is reported, its floor and its held-out gaps.

mod findings;
mod held_out;
pub(super) mod objections;
mod reported_floor;

use fd_effect::Candidate;
use fd_sim::model::Model;

use self::{
    findings::{elsewhere, findings, of_controller},
    held_out::{Noise, held_out_gaps},
    objections::{Claim, doubt, objections},
    reported_floor::{around_the_loop, reported_floor},
};
use super::{
    case::Case,
    context::Context,
    feedback::Feedback,
    judge::{
        groups,
        judged::{Judged, NamedPairs},
        sides,
    },
    objection::Objection,
    prepare::noise::KnownNoise,
    result::{Cause, Diagnosis, NotTested, Verdict},
    search::searched::Searched,
    weigh::{
        answer::{Answer, Fit},
        explain::{explain, nominal_explanation},
        singles::Singles,
        values::FittedValues,
    },
};
use crate::{
    estimate::{Calibrated, parameters},
    fit::{FitError, Log, Minimum, NullFit, Problem},
    quality::Finding,
    shrink::as_begun,
};

/// Innovation, as a fraction of the noise, below which noise is slow: neighbouring samples show less than half of it.
const SLOW: f64 = 0.5;

/// Reports the best answer; the refitted model where there is no gap. What is reported is the simulator
/// as it came in the `case`, with its loop closed, whatever the controller saw while causes were sought.
pub(super) fn report(
    judged: Judged<'_>,
    case: &Case<'_>,
    feedback: &Feedback<'_>,
    context: &Context<'_>,
) -> Result<Diagnosis, FitError> {
    let not_tested = not_tested(&judged.singles, context);
    let simulations = simulations(&judged);
    let first_follows = judged.singles.does_first_follow_anything();
    let idle = idle(&judged.singles.searched.null);
    let Judged { verdict, regime, mut probabilities, singles, ties, pairs, windows, .. } = judged;
    let (answer, lack_of_fit) = match verdict {
        Verdict::NoGap => (singles.refit.clone(), singles.lack_of_fit(&singles.refit)),
        _ => (judged.best, judged.lack_of_fit),
    };
    let Singles { searched, base, refit, causes, .. } = singles;
    let is_in_motion = base.plan().logs.iter().any(|log| log.is_in_motion);
    let slow_noise = searched.slow_noise(SLOW);
    let Searched { model, null, noise, is_coloured, .. } = searched;
    let mut floor = reported_floor(&answer, &lack_of_fit, &noise, is_coloured);
    let slow_noise = told(slow_noise, &noise, &floor);
    let parameters = parameters_with(&answer, &null);

    let nominal = feedback.closed(case, &model, &base)?;
    let closed = |Fit { problem, minimum }: &Fit| {
        let problem = feedback.closed(case, &answer.explanation.model, problem)?;
        Ok::<_, FitError>(Fit { problem, minimum: minimum.clone() })
    };
    let fit = answer.fit.as_ref().map(closed).transpose()?;
    // Where the controller was on logged outputs, what was explained so is explained once more.
    let again = |model: &Model, problem: &Problem, at: &Minimum| {
        feedback.is_logged().then(|| explain(model, &mut problem.clone(), &at.z)).flatten()
    };
    let refitted = again(&model, &nominal, &null.minimum).unwrap_or(refit.explanation);
    let best = match &fit {
        Some(Fit { problem, minimum }) => again(&answer.explanation.model, problem, minimum)
            .unwrap_or_else(|| answer.explanation.clone()),
        None => refitted.clone(),
    };
    around_the_loop(&mut floor, &answer.explanation.gap, &best.gap);
    let known = model.external_inputs().len();
    let mut findings = findings(case.logs, &nominal, known, &noise.stated, &refit.errors)?;
    without_commands(&mut findings, case.logs.len(), context.case.nominal.commanded());
    findings.extend(elsewhere(nominal.plan(), &best.starts, nominal.simulator().initial()));
    let logs = Log::held_out(case.held_out, nominal.simulator(), case.logs, &nominal.plan().logs)?;
    let values = match &fit {
        Some(Fit { problem, minimum }) => FittedValues::of(problem, minimum),
        None => FittedValues::of(&null.problem, &null.minimum).on(nominal.simulator()),
    };
    let logs = as_begun(nominal.simulator(), values.settled(), logs, &noise.sigma)?;
    let known = Noise { sigma: &noise.sigma, floors: &floor };
    let held_out =
        held_out_gaps(&nominal, &null, fit.as_ref(), &logs, known, &judged.horizons, context)?;
    context.monitor.advance();

    let mut causes: Vec<Cause> = causes.into_iter().map(|ranked| ranked.cause).collect();
    let NamedPairs { mut pairs, tied: tied_pairs, .. } = pairs;
    let named: Vec<&Cause> = match (verdict, pairs.first()) {
        (Verdict::Cause | Verdict::Tied, _) => causes.iter().take(1).collect(),
        (Verdict::Pair, Some(pair)) => pair.causes.iter().collect(),
        _ => Vec::new(),
    };
    let follows = first_follows && named.len() == 1 && ties.tied.len() < 2;
    let (answer, held, logs) = (&answer, &held_out[..], &base.plan().logs);
    let claim = Claim { causes: &named, follows, answer, held_out: held, noise: known, logs };
    let objections = objections(claim, verdict);
    let is_forbidden = !named.is_empty() && objections.iter().any(Objection::forbids);
    let verdict = if is_forbidden && !context.settings.without.vetoes {
        doubt(&mut probabilities, &mut causes, &mut pairs);
        Verdict::Unclear
    } else {
        verdict
    };
    Ok(Diagnosis {
        verdict,
        regime,
        is_logged_loop: feedback.is_logged(),
        can_see_the_log: feedback.can_see_the_log(),
        no_gap: probabilities.no_gap,
        none_of_these: probabilities.none_of_these,
        groups: groups(&causes, &pairs),
        sides: sides(&causes, &pairs),
        causes,
        tied: ties.tied,
        rivals: ties.rivals,
        pairs,
        tied_pairs,
        leftover: lack_of_fit.leftover,
        nominal: nominal_explanation(&model, &nominal)?,
        refit: refitted,
        is_unexplained: lack_of_fit.is_unexplained,
        best,
        parameters,
        steps: noise.steps(),
        sigma: noise.sigma,
        floor,
        is_coloured,
        slow_noise,
        objections,
        held_out,
        findings,
        not_tested,
        idle,
        is_in_motion,
        windows,
        cleaned: None,
        is_stopped: context.monitor.is_stopped(),
        simulations,
    })
}

/// The uncertain parameters with an answer, or without any effect. Errors of a model that lacks something are no noise, but the
/// only measure of what they hide.
fn parameters_with(answer: &Answer, null: &NullFit) -> Vec<Calibrated> {
    let left = answer.explanation.gap.iter().copied().fold(1.0, f64::max);
    match &answer.fit {
        Some(Fit { problem, minimum }) => parameters(problem, minimum, left),
        None => parameters(&null.problem, &null.minimum, left),
    }
}

/// Of outputs that a controller makes of the logs nothing is said but that.
fn without_commands(findings: &mut Vec<Finding>, logs: usize, commanded: &[String]) {
    findings.retain(|finding| !commanded.contains(&finding.channel));
    findings.extend((1..=logs).flat_map(|log| of_controller(log, commanded)));
}

/// Outputs of which slow noise is told: those that have it, and those with noise of unknown size that is twice what
/// neighbouring samples show.
fn told(slow: Vec<bool>, noise: &KnownNoise, floor: &[f64]) -> Vec<bool> {
    let told = slow.into_iter().enumerate();
    told.map(|(c, is)| is || noise.slow[c] && 1.0 < SLOW * floor[c]).collect()
}

/// What could not be tried: refused, not simulated, or without a trace in the measurement.
fn not_tested(singles: &Singles<'_>, context: &Context<'_>) -> Vec<NotTested> {
    let is_seen = |c: &Candidate| singles.measured.iter().any(|m| std::ptr::eq(m.candidate, c));
    let unseen = context.candidates.measured.iter().filter(|candidate| !is_seen(candidate));
    let unseen = unseen.map(|c| NotTested::of(c, "there is nothing of it in the log".into()));
    let refused = context.candidates.refused.iter().chain(&singles.searched.not_tested);
    refused.cloned().chain(unseen).collect()
}

/// Parameters on which no residual depends.
fn idle(null: &NullFit) -> Vec<String> {
    let parameters = &null.problem.simulator().parameters();
    let nuisances = null.problem.plan().nuisances().iter().zip(null.minimum.slopes.iter());
    let idle = nuisances.filter(|(_, slopes)| slopes.iter().all(|slope| *slope == 0.0));
    let names = idle.map(|(variable, _)| variable.name.clone());
    names.filter(|name| parameters.iter().any(|known| known.name == *name)).collect()
}

/// Simulations of all logs that were made.
pub(super) fn simulations(judged: &Judged<'_>) -> usize {
    let Singles { searched, base, .. } = &judged.singles;
    let pairs = judged.pairs.fitted.iter().map(|pair| &pair.fit.problem);
    let fits = searched.trials.iter().map(|trial| &trial.problem).chain(pairs);
    base.simulations() + searched.screening + fits.map(Problem::simulations).sum::<usize>()
}
