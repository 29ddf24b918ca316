//! From a model, candidates and logs to an answer.
//!
//! 1. The nuisances are fitted alone ([`null_fit`](crate::fit::null_fit)).
//! 2. Every candidate is scored at every start by what it could explain besides the nuisances,
//!    and fitted a little from the best three.
//! 3. The best causes (effect and site, all their laws) are fitted to the end.
//! 4. If what the best one leaves has a colour, everything is fitted again with whitened errors.
//! 5. Evidence, pooled over the laws of a cause; probabilities; what the log cannot separate.
//! 6. Forecasts of held-out logs, without and with the best cause.
//!
//! Candidates are spread over threads; the answer does not depend on their number.

mod answer;
mod case;
mod explain;
mod held_out;
mod judge;
mod leftover;
mod monitor;
mod observe;
mod offered;
mod pairs;
mod prepare;
mod rank;
mod result;
mod search;
mod separate;
mod settings;
mod steps;
mod trial;

use self::{
    answer::Answer,
    explain::{explain, nominal_explanation},
    held_out::compare,
    judge::{judge, verdict, worth},
    observe::observe,
    offered::Offered,
    pairs::{Duo, PAIR, Workshop, merge, observed_beside, seek_pairs},
    prepare::{Prepared, inspect_all, prepare},
    rank::{Yardstick, groups, rank, sides},
    search::{Found, search},
    separate::separate,
    steps::refine,
};
pub use self::{
    case::Case,
    monitor::{Monitor, Stage},
    result::{
        Cause, Diagnosis, Estimate, Explanation, Group, HeldOut, Leftover, NotTested, Pair, Regime,
        Start, Verdict,
    },
    settings::Settings,
};
use crate::{
    evidence::{evidence, likelihood},
    fit::{FitError, Log, Problem},
};

/// Log-likelihood that something else could gain from which second causes are tried.
const SOMETHING: f64 = 3.0;

/// Diagnoses the gap between a model and logs of the real system.
///
/// ```
/// use fd_gap::{diagnose::{Case, Settings, Verdict, diagnose}, effect::Candidate, model::Model};
/// use fd_model::{Channel, Record};
///
/// let model: Model = r#"
/// version = 1
/// kind = "equations"
/// name = "lag"
/// sample_time = 0.1
/// inputs = { u = { unit = "V" } }
/// outputs = { y = { unit = "V", value = "x", noise = 0.01 } }
/// parameters = { T = { unit = "s", value = 1.0 } }
/// states = { x = { unit = "V", initial = 0.0, derivative = "(u - x)/T" } }
/// "#.parse()?;
/// let (u, y) = ([Channel::new("u", "V")], [Channel::new("y", "V")]);
/// let noise = |k: u32| 0.01 * f64::from(k * 7919 % 13).sin();
/// let x = |k: u32| 1.0 - (-0.1 * f64::from(k)).exp();
/// let rows = (0..100).map(|k| ([1.0], [x(k) + noise(k)]));
/// let log = Record::from_rows(u.to_vec(), y.to_vec(), rows, model.sample_time()?)?;
/// let suspects: Vec<Candidate> = Vec::new();
/// let case = Case { nominal: &model, suspects: &suspects, logs: &[log], held_out: &[] };
/// let diagnosis = diagnose(&case, &Settings::default(), &())?;
/// assert_eq!((diagnosis.verdict, diagnosis.no_gap), (Verdict::NoGap, 1.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// Returns an error when the model cannot be simulated or does not fit the logs. A candidate that
/// cannot be simulated is no error; see [`Diagnosis::not_tested`].
pub fn diagnose(
    case: &Case<'_>,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Diagnosis, FitError> {
    let Case { nominal, suspects, logs, held_out } = *case;
    let Prepared { mut model, null, noise } = prepare(case, settings)?;
    let offers = Offered::of(suspects);
    let mut not_tested = offers.refused;
    let Found { mut null, mut trials, not_tested: failed, is_coloured, lines } =
        search(null, nominal, &offers.simulated, &noise, settings, monitor)?;
    not_tested.extend(failed);
    refine(nominal, &mut model, &mut null, &mut trials)?;

    monitor.begin(Stage::Judge, 2);
    let mut base = null.problem.clone();
    let errors = base.errors(&null.minimum.z).ok_or(FitError::Diverged)?;
    let findings = inspect_all(logs, &base, &noise.stated, &errors)?;
    let refit = explain(&model, &mut base, &null.minimum.z).ok_or(FitError::Diverged)?;
    let priors = noise.priors(is_coloured);
    let reference = evidence(&base, &null.minimum, &likelihood(&errors, &priors), &[])
        .ok_or(FitError::Diverged)?;
    let yardstick = Yardstick { noise: &priors, reference };
    let mut observed = Vec::new();
    for candidate in &offers.observed {
        match observe(candidate, &errors, &noise, is_coloured) {
            Some(found) => observed.push((candidate, found)),
            None => not_tested.push(NotTested::of(candidate, "nothing of it in the log".into())),
        }
    }
    let mut causes = rank(&mut trials, &observed, &refit, yardstick);
    let (tied, rivals) = separate(&causes, &mut trials, settings);
    monitor.advance();

    let refitted = Answer { explanation: refit.clone(), errors, fit: None, log_evidence: 0.0 };
    let rest = |answer: &Answer| answer.rest(&refitted, &base, &noise, is_coloured);
    let single = Answer::first(&causes, &trials, &refitted)
        .filter(|single| worth(settings, causes.len()) < single.log_evidence);
    let mut best = single.unwrap_or_else(|| refitted.clone());
    let mut left = rest(&best);
    let mut duos = Vec::new();
    if left.is_unexplained || SOMETHING < left.leftover.level + left.leftover.pattern {
        let workshop = Workshop { nominal, suspects, null: &null, lines: &lines, yardstick };
        duos = seek_pairs(workshop, &trials, &causes, monitor);
    }
    let beside = observed_beside(&causes, &best, &offers.observed, &noise, is_coloured);
    let (mut pairs, tied_pairs) = merge(&mut duos, beside, &causes, settings);
    if let Some(answer) = duos.first().and_then(Duo::answer)
        && best.log_evidence + PAIR < answer.log_evidence
    {
        best = answer;
        left = rest(&best);
    }
    let judgement = judge(&mut causes, &mut pairs, best.log_evidence, &left.leftover, settings);
    let verdict = verdict(judgement, &causes, &tied, &pairs);
    if verdict == Verdict::NoGap {
        best = refitted.clone();
        left = rest(&best);
    }
    let causes: Vec<Cause> = causes.into_iter().map(|(_, cause)| cause).collect();

    let longest: Result<Vec<Log>, _> =
        held_out.iter().enumerate().map(|(i, r)| Log::new(r, base.simulator(), i + 1)).collect();
    let leader = best.fit.as_ref().map(|(problem, minimum)| (problem, minimum));
    let held_out =
        compare(base.simulator(), &null, leader, &longest?, [&noise.sigma, &left.floor], settings)?;
    monitor.advance();
    let fits = trials.iter().map(|t| &t.problem).chain(duos.iter().map(|duo| &duo.problem));
    let simulations = base.simulations() + fits.map(Problem::simulations).sum::<usize>();
    Ok(Diagnosis {
        verdict,
        regime: Regime::AtTheFloor,
        no_gap: judgement.no_gap,
        none_of_these: judgement.none_of_these,
        groups: groups(&causes),
        sides: sides(&causes),
        causes,
        tied,
        rivals,
        pairs,
        tied_pairs,
        leftover: left.leftover,
        nominal: nominal_explanation(&model, &base)?,
        refit,
        is_unexplained: left.is_unexplained,
        best: best.explanation,
        sigma: noise.sigma,
        floor: left.floor,
        is_coloured,
        held_out,
        findings,
        not_tested,
        simulations,
    })
}
