//! From a model, candidates and logs to an answer.
//!
//! 1. The nuisances are fitted alone ([`null_fit`]).
//! 2. Every candidate is scored at every start by what it could explain besides the nuisances,
//!    and fitted a little from the best three.
//! 3. The best causes (effect and site, all their laws) are fitted to the end.
//! 4. If what the best one leaves has a colour, everything is fitted again with whitened errors.
//! 5. Evidence, pooled over the laws of a cause; probabilities; what the log cannot separate.
//! 6. Forecasts of held-out logs, without and with the best cause.
//!
//! Candidates are spread over threads; the answer does not depend on their number.

mod held_out;
mod result;
mod search;
mod settings;
mod trial;

use std::sync::Arc;

use fd_model::Record;

use self::{
    held_out::compare,
    search::{Found, search},
    trial::Trial,
};
pub use self::{
    result::{Cause, Diagnosis, Estimate, HeldOut},
    settings::Settings,
};
use crate::{
    effect::Candidate,
    evidence::{SEPARATED, distance, evidence, likelihood, pool, posterior},
    fit::{FitError, Log, NullFit, Plan, Problem, Weights, null_fit},
    model::Model,
    quality::{Finding, inspect, noise_floor, robust_third_difference_floor},
    shrink::{gap, gap_per_output},
    simulate::EquationSimulator,
};

/// Spread of `ln` of the noise where the model states it, and where it does not.
const NOISE_SPREAD: [f64; 2] = [0.15, 0.5];
/// A stated noise is believed up to this factor below what third differences show …
const BELIEVED: f64 = 1.25;
/// … and never raised by more than this.
const RAISED: f64 = 4.0;
/// `ln(rms/floor)` from which a residual is unexplained.
const UNEXPLAINED: f64 = 0.2;
/// Rivals that are refitted to the simulation of the best cause.
const MOST_RIVALS: usize = 8;

/// Diagnoses the gap between a model and logs of the real system.
///
/// ```
/// use fd_gap::{diagnose::{Settings, diagnose}, model::Model};
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
/// let diagnosis = diagnose(&model, &[], &[log], &[], &Settings::default())?;
/// assert_eq!(diagnosis.no_gap, 1.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// Returns an error when the model cannot be simulated or does not fit the logs. A candidate that
/// cannot be simulated is no error; see [`Diagnosis::not_tested`].
pub fn diagnose(
    model: &Model,
    candidates: &[Candidate],
    logs: &[Record],
    held_out: &[Record],
    settings: &Settings,
) -> Result<Diagnosis, FitError> {
    let ts = logs.first().ok_or(FitError::NoLog)?.ts();
    let nominal = EquationSimulator::<f64>::at(model, ts)?;
    let plan = Arc::new(Plan::new(&nominal, logs, settings.horizon)?);
    let stated: Vec<Option<f64>> = model.outputs.iter().map(|output| output.noise).collect();
    let null = weighted_null_fit(&plan, &nominal, &stated)?;
    let sigma = null.problem.weights().sigma.clone();
    let spread: Vec<f64> =
        stated.iter().map(|stated| NOISE_SPREAD[usize::from(stated.is_none())]).collect();

    let Found { null, mut trials, not_tested, is_coloured } =
        search(null, candidates, &spread, settings)?;
    let mut simulations = null.problem.simulations();
    simulations += trials.iter().map(|trial| trial.problem.simulations()).sum::<usize>();

    let mut base = null.problem.clone();
    let errors = base.errors(&null.minimum.z).ok_or(FitError::Diverged)?;
    let refit_gap = gap_per_output(&errors);
    let findings = inspect_all(logs, &base, &stated, &errors)?;
    let base_likelihood = likelihood(&errors, &spread, is_coloured);
    let reference =
        evidence(&base, &null.minimum, &base_likelihood, &[]).ok_or(FitError::Diverged)?;

    // Trials come back in the order of the candidates; laws of a cause are neighbours or not.
    let mut groups: Vec<(Vec<usize>, Vec<f64>)> = Vec::new();
    let mut laws: Vec<(f64, f64, f64)> = Vec::with_capacity(trials.len());
    for i in 0..trials.len() {
        laws.push(trials[i].weigh(&spread, is_coloured, reference));
        let of = |j: usize| trials[j].candidate;
        let same = |(members, _): &&mut (Vec<usize>, Vec<f64>)| {
            let (a, b) = (of(members[0]), of(i));
            a.label == b.label && a.site == b.site && a.partner == b.partner
        };
        match groups.iter_mut().find(same) {
            Some((members, weights)) => {
                members.push(i);
                weights.push(laws[i].0);
            }
            None => groups.push((vec![i], vec![laws[i].0])),
        }
    }
    let pooled: Vec<f64> = groups.iter().map(|(_, weights)| pool(weights)).collect();
    let probabilities = posterior(&pooled, settings.no_gap, settings.temperature);
    let mut causes: Vec<(usize, Cause)> = groups
        .iter()
        .enumerate()
        .map(|(g, (members, _))| {
            let heaviest = |a: &&usize, b: &&usize| laws[**a].0.total_cmp(&laws[**b].0);
            let best = members.iter().max_by(heaviest).copied().unwrap_or(members[0]);
            let cause = trials[best].cause(laws[best], pooled[g], probabilities.causes[g]);
            (best, cause)
        })
        .collect();
    causes.sort_by(|(_, a), (_, b)| b.log_evidence.total_cmp(&a.log_evidence));

    let (tied, rivals) = separate(&causes, &mut trials, settings);
    let leader = causes.first().map(|(trial, _)| *trial);
    let best_errors = match leader {
        Some(trial) => trials[trial].errors(),
        None => Some(errors.clone()),
    };
    let best_errors = best_errors.unwrap_or(errors);
    let best_gap = gap_per_output(&best_errors);
    let floor: Vec<f64> = best_errors
        .iter()
        .zip(&stated)
        .zip(&sigma)
        .zip(&best_gap)
        .map(|(((signals, stated), sigma), gap)| {
            let stated = stated.map(|stated| stated / sigma);
            let floor = noise_floor(&signals.join(&f64::NAN), stated).unwrap_or(1.0);
            // Slow noise of the stated size is noise, whatever its innovation.
            stated.filter(|_| is_coloured).map_or(floor, |stated| floor.max(gap.min(stated)))
        })
        .collect();
    let is_unexplained = best_gap.iter().zip(&floor).any(|(gap, f)| UNEXPLAINED < (gap / f).ln());
    let nuisances = leader.map_or_else(
        || held_out::nuisances(&null.problem, &null.minimum.z),
        |trial| trials[trial].nuisances(),
    );
    let mut diagnosis = Diagnosis {
        no_gap: probabilities.no_gap,
        causes: causes.into_iter().map(|(_, cause)| cause).collect(),
        tied,
        rivals,
        sigma,
        floor,
        refit_gap,
        best_gap,
        is_unexplained,
        is_coloured,
        nuisances,
        held_out: Vec::new(),
        findings,
        not_tested,
        simulations,
    };
    if !held_out.is_empty() {
        let logs: Result<Vec<Log>, _> =
            held_out.iter().enumerate().map(|(i, r)| Log::new(r, &nominal, i + 1)).collect();
        let leader = leader.map(|trial| &trials[trial]);
        diagnosis.held_out = compare(&nominal, &null, leader, &logs?, &diagnosis, settings)?;
    }
    Ok(diagnosis)
}

/// Fits the nuisances with the stated noise, or that which third differences show; a stated noise
/// that is clearly too small is raised.
fn weighted_null_fit(
    plan: &Arc<Plan>,
    nominal: &EquationSimulator,
    stated: &[Option<f64>],
) -> Result<NullFit, FitError> {
    let measured = |c: usize| {
        let signals = plan
            .logs
            .iter()
            .map(|log| log.y.iter().skip(c).step_by(log.ny).copied().collect::<Vec<f64>>());
        signals.collect::<Vec<_>>().join(&f64::NAN)
    };
    let guess = |c: usize| {
        let signal = measured(c);
        let largest = signal.iter().filter(|v| v.is_finite()).fold(0.0_f64, |m, v| m.max(v.abs()));
        // A perfectly smooth signal still has rounding errors.
        let smallest = (1e-9 * largest).max(f64::MIN_POSITIVE);
        robust_third_difference_floor(&signal).unwrap_or(smallest).max(smallest)
    };
    let sigma = stated.iter().enumerate().map(|(c, stated)| stated.unwrap_or_else(|| guess(c)));
    let first = null_fit(plan, nominal, &Weights::white(sigma.collect()))?;
    let mut problem = first.problem.clone();
    let errors = problem.errors(&first.minimum.z).ok_or(FitError::Diverged)?;
    let old = &first.problem.weights().sigma;
    let new: Vec<f64> = errors
        .iter()
        .zip(old)
        .zip(stated)
        .map(|((signals, old), stated)| {
            let shown =
                robust_third_difference_floor(&signals.join(&f64::NAN)).unwrap_or(1.0) * old;
            match stated {
                Some(stated) if shown <= BELIEVED * stated => *stated,
                Some(stated) => shown.min(RAISED * stated),
                None => shown.max(1e-3 * old),
            }
        })
        .collect();
    if new == *old { Ok(first) } else { null_fit(plan, nominal, &Weights::white(new)) }
}

/// Findings in all logs, with the errors that the null fit has left in each.
fn inspect_all(
    logs: &[Record],
    null: &Problem,
    stated: &[Option<f64>],
    errors: &[Vec<Vec<f64>>],
) -> Result<Vec<Finding>, FitError> {
    let mut findings = Vec::new();
    for (i, log) in logs.iter().enumerate() {
        let left = |signals: &Vec<Vec<f64>>| -> Vec<f64> {
            let segments = null.plan().segments().iter().zip(signals);
            segments.filter(|(s, _)| s.log == i).flat_map(|(_, e)| e).copied().collect()
        };
        let left: Vec<Vec<f64>> = errors.iter().map(left).collect();
        findings.extend(inspect(log, null.simulator(), stated, Some(&left), i + 1)?);
    }
    Ok(findings)
}

/// Places of the causes that this log cannot tell from the first, and of those that are nearly as
/// probable but could be told apart.
fn separate(
    causes: &[(usize, Cause)],
    trials: &mut [Trial<'_>],
    settings: &Settings,
) -> (Vec<usize>, Vec<(usize, f64)>) {
    let Some((leader, first)) = causes.first() else { return (vec![], vec![]) };
    let (mut tied, mut rivals) = (vec![0], vec![]);
    let Some(at) = trials[*leader].best.clone() else { return (tied, rivals) };
    let mut truth = trials[*leader].problem.clone();
    let near = causes.iter().enumerate().skip(1).take_while(|(_, (_, cause))| {
        first.log_evidence - cause.log_evidence < settings.bayes_factor.ln()
    });
    for (place, (trial, _)) in near.take(MOST_RIVALS) {
        let Some(rival_at) = &trials[*trial].best else { continue };
        let left = distance(&mut truth, &at, &trials[*trial].problem, rival_at);
        if left < SEPARATED {
            tied.push(place);
        } else {
            rivals.push((place, left));
        }
    }
    (tied, rivals)
}

impl Trial<'_> {
    fn errors(&mut self) -> Option<Vec<Vec<Vec<f64>>>> {
        let best = self.best.as_ref()?;
        self.problem.errors(&best.z)
    }

    fn nuisances(&self) -> Vec<(String, f64, f64)> {
        self.best.as_ref().map_or_else(Vec::new, |best| held_out::nuisances(&self.problem, &best.z))
    }

    /// Evidence over that of "no gap", gap, and the noise in sigma.
    fn weigh(&mut self, spread: &[f64], is_coloured: bool, reference: f64) -> (f64, f64, f64) {
        let hopeless = (f64::NEG_INFINITY, f64::NAN, 1.0);
        let Some(errors) = self.errors() else { return hopeless };
        let Some(best) = &self.best else { return hopeless };
        let likelihood = likelihood(&errors, spread, is_coloured);
        let scale = likelihood.scale.iter().copied().fold(0.0, f64::max);
        match evidence(&self.problem, best, &likelihood, &self.strengths) {
            Some(evidence) => (evidence - reference, gap(&errors), scale),
            None => hopeless,
        }
    }

    fn cause(
        &self,
        (_, gap, scale): (f64, f64, f64),
        log_evidence: f64,
        probability: f64,
    ) -> Cause {
        let candidate = self.candidate;
        let values = self.best.as_ref().map(|best| self.problem.effect_values(&best.z));
        let deviations =
            self.best.as_ref().and_then(|best| self.problem.standard_errors(best, scale));
        let parameters = candidate.parameters.iter().enumerate().map(|(i, p)| Estimate {
            name: p.name.clone(),
            unit: p.unit.clone(),
            value: values.as_ref().map_or(f64::NAN, |values| values[i]),
            standard_error: deviations.as_ref().map_or(f64::NAN, |d| d[i]),
            is_strength: p.is_strength,
        });
        Cause {
            label: candidate.label,
            site: candidate.site.clone(),
            partner: candidate.partner.clone(),
            family: candidate.family,
            side: candidate.side,
            probability,
            log_evidence,
            law: candidate.law,
            candidate: self.index,
            parameters: parameters.collect(),
            gap,
        }
    }
}
