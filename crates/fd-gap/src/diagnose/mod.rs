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

mod case;
mod explain;
mod held_out;
mod monitor;
mod prepare;
mod rank;
mod result;
mod search;
mod separate;
mod settings;
mod trial;

use std::sync::Arc;

pub use self::{
    case::Case,
    monitor::{Monitor, Stage},
    result::{
        Cause, Diagnosis, Estimate, Explanation, Group, HeldOut, NotTested, Pair, Regime, Start,
        Verdict,
    },
    settings::Settings,
};
use self::{
    explain::{explain, nominal_explanation},
    held_out::compare,
    prepare::{inspect_all, weighted_null_fit},
    rank::{Noise, groups, rank, sides},
    search::{Found, search},
    separate::separate,
};
use crate::{
    evidence::{evidence, likelihood},
    fit::{FitError, Log, Plan},
    quality::noise_floor,
};

/// Spread of `ln` of the noise where the model states it, and where it does not.
const NOISE_SPREAD: [f64; 2] = [0.15, 0.5];
/// `ln(rms/floor)` from which a residual is unexplained.
const UNEXPLAINED: f64 = 0.2;
/// Probability from which a cause, or "no gap", is named.
const NAMED: f64 = 0.5;

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
    let ts = logs.first().ok_or(FitError::NoLog)?.ts();
    let simulator = nominal.simulator(ts)?;
    let plan = Arc::new(Plan::new(&*simulator, logs, settings.horizon)?);
    let stated: Vec<Option<f64>> = nominal.model().outputs.iter().map(|o| o.noise).collect();
    let null = weighted_null_fit(&plan, &*simulator, &stated)?;
    let sigma = null.problem.weights().sigma.clone();
    let spread: Vec<f64> =
        stated.iter().map(|stated| NOISE_SPREAD[usize::from(stated.is_none())]).collect();

    let (mut candidates, mut not_tested) = (Vec::new(), Vec::new());
    for offer in suspects.alone() {
        match offer {
            Ok(candidate) => candidates.push(candidate),
            Err(refusal) => not_tested.push(NotTested::from(&refusal)),
        }
    }
    let Found { null, mut trials, not_tested: failed, is_coloured } =
        search(null, nominal, &candidates, &spread, settings, monitor)?;
    not_tested.extend(failed);

    monitor.begin(Stage::Judge, 2);
    let mut base = null.problem.clone();
    let errors = base.errors(&null.minimum.z).ok_or(FitError::Diverged)?;
    let findings = inspect_all(logs, &base, &stated, &errors)?;
    let base_likelihood = likelihood(&errors, &spread, is_coloured);
    let reference =
        evidence(&base, &null.minimum, &base_likelihood, &[]).ok_or(FitError::Diverged)?;
    let noise = Noise { spread: &spread, is_coloured, reference };
    let (no_gap, causes) = rank(&mut trials, noise, settings);
    let (tied, rivals) = separate(&causes, &mut trials, settings);
    monitor.advance();

    let verdict =
        verdict(no_gap, &causes.iter().map(|(_, c)| c.probability).collect::<Vec<_>>(), &tied);
    let refit = explain(nominal.model(), &mut base, &null.minimum.z).ok_or(FitError::Diverged)?;
    let leader = causes.first().map(|(trial, _)| *trial).filter(|_| verdict != Verdict::NoGap);
    let (best, best_errors) = match leader {
        Some(trial) => {
            let trial = &mut trials[trial];
            let z = trial.best.as_ref().ok_or(FitError::Diverged)?.z.clone();
            let best = explain(&trial.candidate.model, &mut trial.problem, &z);
            (best, trial.errors())
        }
        None => (Some(refit.clone()), Some(errors)),
    };
    let (best, best_errors) = best.zip(best_errors).ok_or(FitError::Diverged)?;
    let floor: Vec<f64> = best_errors
        .iter()
        .zip(&stated)
        .zip(&sigma)
        .zip(&best.gap)
        .map(|(((signals, stated), sigma), gap)| {
            let stated = stated.map(|stated| stated / sigma);
            let floor = noise_floor(&signals.join(&f64::NAN), stated).unwrap_or(1.0);
            // Slow noise of the stated size is noise, whatever its innovation.
            stated.filter(|_| is_coloured).map_or(floor, |stated| floor.max(gap.min(stated)))
        })
        .collect();
    let is_unexplained = best.gap.iter().zip(&floor).any(|(gap, f)| UNEXPLAINED < (gap / f).ln());
    let held_out_logs: Result<Vec<Log>, _> =
        held_out.iter().enumerate().map(|(i, r)| Log::new(r, &*simulator, i + 1)).collect();
    let leader = leader.map(|trial| &trials[trial]);
    let held_out =
        compare(&*simulator, &null, leader, &held_out_logs?, [&sigma, &floor], settings)?;
    monitor.advance();
    let simulations =
        base.simulations() + trials.iter().map(|trial| trial.problem.simulations()).sum::<usize>();
    let causes: Vec<Cause> = causes.into_iter().map(|(_, cause)| cause).collect();
    Ok(Diagnosis {
        verdict,
        regime: Regime::AtTheFloor,
        no_gap,
        none_of_these: 0.0,
        groups: groups(&causes),
        sides: sides(&causes),
        causes,
        tied,
        rivals,
        pairs: Vec::new(),
        nominal: nominal_explanation(nominal.model(), &base)?,
        refit,
        best,
        sigma,
        floor,
        is_unexplained,
        is_coloured,
        held_out,
        findings,
        not_tested,
        simulations,
    })
}

/// The answer in one word, from probabilities of single causes.
fn verdict(no_gap: f64, causes: &[f64], tied: &[usize]) -> Verdict {
    let first = causes.first().copied().unwrap_or(0.0);
    let set: f64 = tied.iter().filter_map(|&place| causes.get(place)).sum();
    if NAMED < no_gap || causes.is_empty() {
        Verdict::NoGap
    } else if tied.len() == 1 && NAMED < first {
        Verdict::Cause
    } else if NAMED < set {
        Verdict::Tied
    } else {
        Verdict::Unclear
    }
}
