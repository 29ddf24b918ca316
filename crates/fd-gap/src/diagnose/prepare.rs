//! Before any candidate is tried: the noise, the fit of the nuisances, the quality of the logs.

use std::sync::Arc;

use fd_model::{Record, SampleTime};
use fd_sim::{
    model::Model,
    simulate::{EquationSimulator, Simulator},
};

use super::{attempt::REACHED, case::Case};
use crate::{
    evidence::NoisePrior,
    fit::{FitError, Horizon, Log, NullFit, Plan, Problem, Weights, null_fit},
    quality::{Defect, Finding, grid_step, inspect, noise_floor, robust_third_difference_floor},
    shrink::{dominant_time_constant, gap_per_output},
};

/// A stated noise is believed up to this factor below what third differences show …
const BELIEVED: f64 = 1.25;
/// … and never raised by more than this.
const RAISED: f64 = 4.0;

/// Spread of `ln` of the noise where the model states it, and where it does not.
const NOISE_SPREAD: [f64; 2] = [0.1, 0.5];
/// A grid above this many times the noise colours it: errors of rounding are no noise of a filter.
const COARSE: f64 = 1.0;

/// Times the stated noise that the best explanation leaves from which likelihoods are no use.
const FAR: f64 = 5.0;

/// What a diagnosis begins with.
#[derive(Debug)]
pub(super) struct Prepared {
    /// The nominal model, its integration step pinned.
    pub(super) model: Model,
    /// The fit without any effect.
    pub(super) null: NullFit,
    /// What is known of the noise.
    pub(super) noise: KnownNoise,
}

/// What is known of the noise of each output.
#[derive(Clone, Debug)]
pub(super) struct KnownNoise {
    /// What the model states, in the unit of the output.
    pub(super) stated: Vec<Option<f64>>,
    /// Steps of grids that measured values lie on, in the unit of the output.
    pub(super) grids: Vec<Option<f64>>,
    /// What residuals are measured in, in the unit of the output.
    pub(super) sigma: Vec<f64>,
}

impl KnownNoise {
    /// The noise of each output as an unknown, in units of sigma.
    pub(super) fn priors(&self, is_coloured: bool) -> Vec<NoisePrior> {
        let of = |((stated, sigma), grid): ((&Option<f64>, &f64), &Option<f64>)| {
            let is_coarse = grid.is_some_and(|step| COARSE * sigma < step);
            let prior = NoisePrior::white(NOISE_SPREAD[usize::from(stated.is_none())]);
            let centre = stated.map_or(0.0, |stated| (stated / sigma).ln());
            NoisePrior { centre, ..prior }.coloured(is_coloured && !is_coarse)
        };
        self.stated.iter().zip(&self.sigma).zip(&self.grids).map(of).collect()
    }

    /// How many times the noise is in errors (in sigma), in the output with the most; where none is
    /// stated, how many times their own floor.
    pub(super) fn reach(&self, errors: &[Vec<Vec<f64>>]) -> f64 {
        self.reaches(errors).into_iter().map(|(reach, _)| reach).fold(0.0, f64::max)
    }

    /// Whether errors (in sigma) are so far above the noise that likelihoods are no use. Nobody
    /// promises that there is noise as small as an estimated floor, and to reach it nearly is no
    /// success: there, forecasts are better judges.
    pub(super) fn is_far(&self, errors: &[Vec<Vec<f64>>]) -> bool {
        let limit = |is_stated| if is_stated { FAR } else { REACHED };
        self.reaches(errors).into_iter().any(|(reach, is_stated)| limit(is_stated) < reach)
    }

    /// As [`reach`](Self::reach), per output, with whether its noise is stated.
    fn reaches(&self, errors: &[Vec<Vec<f64>>]) -> Vec<(f64, bool)> {
        let gaps = gap_per_output(errors);
        let of = |c: usize| {
            let stated = self.stated[c];
            let floor = match stated {
                Some(stated) => (stated / self.sigma[c]).max(1.0),
                None => noise_floor(&errors[c].join(&f64::NAN), None).unwrap_or(1.0),
            };
            (gaps[c] / floor, stated.is_some())
        };
        (0..errors.len()).map(of).collect()
    }
}

/// Cuts the logs and fits the nuisances.
pub(super) fn prepare(case: &Case<'_>, horizon: Horizon) -> Result<Prepared, FitError> {
    let ts = case.logs.first().ok_or(FitError::NoLog)?.ts();
    let model = pinned(case.nominal.model(), ts);
    let simulator = case.nominal.patched(&model, ts)?;
    let logs = Log::all(case.logs, &*simulator, &[])?;
    let said = model.outputs.iter().map(|output| output.noise.filter(|noise| 0.0 < *noise));
    let stated: Vec<Option<f64>> = said.collect();
    let null = begun(logs, &*simulator, horizon, &stated)?;
    let plan = null.problem.plan();
    let grids = (0..stated.len()).map(|c| grid_step(&measured(plan, c))).collect();
    let sigma = null.problem.weights().sigma.clone();
    Ok(Prepared { model, null, noise: KnownNoise { stated, grids, sigma } })
}

/// The fit without any effect, from the starts that the logs really have. A log need not begin where the
/// model says: one that was cut out of a longer run begins in motion, and a start that is held at the edge
/// of its box bends everything that is fitted after it. With free starts there are more unknowns; they are
/// taken where they lower the sum of squares by more than that many unknowns do by chance, as an F-test of
/// the fit that is there (it need not come near the noise).
fn begun(
    logs: Vec<Log>,
    simulator: &dyn Simulator,
    horizon: Horizon,
    stated: &[Option<f64>],
) -> Result<NullFit, FitError> {
    let fit = |logs: Vec<Log>| -> Result<NullFit, FitError> {
        weighted_null_fit(&Arc::new(Plan::of_logs(simulator, logs, horizon)?), simulator, stated)
    };
    let free: Vec<Log> = logs.iter().map(|log| log.clone().in_motion()).collect();
    let at_rest = fit(logs);
    let in_motion = fit(free);
    match (at_rest, in_motion) {
        (Ok(at_rest), Ok(in_motion)) => {
            Ok(if is_in_motion(&at_rest, &in_motion) { in_motion } else { at_rest })
        }
        // One of them may diverge, or be too short for so many unknowns.
        (Ok(fit), Err(_)) | (Err(_), Ok(fit)) => Ok(fit),
        (Err(error), Err(_)) => Err(error),
    }
}

/// What a free start must gain, per unknown, beyond `ln n`: as much as something needs to be sure.
const SURE: f64 = 10.0;
/// Part of a log within which a start is forgotten …
const BEGINNING: f64 = 1.0 / 3.0;
/// … and the share of the gain that must lie there. What a free start gains all along the log, as the
/// offset of an integrator does, may as well be an effect.
const AT_THE_BEGINNING: f64 = 0.8;

/// Whether free starts explain so much more that the logs cannot have begun where the model says.
fn is_in_motion(at_rest: &NullFit, in_motion: &NullFit) -> bool {
    let sigma = &at_rest.problem.weights().sigma;
    // Sums of squares in the beginnings of all logs, and of all samples.
    let squares = |fit: &NullFit| -> Option<[f64; 2]> {
        let errors = fit.problem.clone().errors(&fit.minimum.z)?;
        let plan = fit.problem.plan();
        let mut sums = [0.0; 2];
        for ((signals, own), common) in errors.iter().zip(&fit.problem.weights().sigma).zip(sigma) {
            for (signal, segment) in signals.iter().zip(plan.segments()) {
                let end = BEGINNING * plan.logs[segment.log].samples() as f64;
                for (k, e) in signal.iter().enumerate().filter(|(_, e)| e.is_finite()) {
                    let square = (e * own / common).powi(2);
                    sums[0] += if ((segment.from + k) as f64) < end { square } else { 0.0 };
                    sums[1] += square;
                }
            }
        }
        Some(sums)
    };
    let (Some(before), Some(after)) = (squares(at_rest), squares(in_motion)) else { return false };
    let n = at_rest.problem.plan().measured() as f64;
    let unknowns = in_motion.problem.plan().own_variables().count() as f64;
    let gain = before[1] - after[1];
    let is_early = AT_THE_BEGINNING * gain < before[0] - after[0];
    is_early && unknowns * (n.ln() + SURE) * after[1] < n * gain
}

/// The model with the integration step that it has with its nominal parameters, whatever they will
/// be.
fn pinned(model: &Model, ts: SampleTime) -> Model {
    let Ok(simulator) = EquationSimulator::<f64>::at(model, ts) else { return model.clone() };
    with_step(model, ts.seconds() / simulator.substeps() as f64)
}

/// The model with another integration step.
pub(super) fn with_step(model: &Model, step: f64) -> Model {
    let mut draft = model.clone().into_draft();
    draft.step = Some(step);
    // A step does not make a correct model wrong.
    Model::try_from(draft).unwrap_or_else(|_| model.clone())
}

/// An output in all logs, one after the other, with a hole between them.
fn measured(plan: &Plan, output: usize) -> Vec<f64> {
    let column =
        |log: &Log| -> Vec<f64> { log.y.iter().skip(output).step_by(log.ny).copied().collect() };
    plan.logs.iter().map(column).collect::<Vec<_>>().join(&f64::NAN)
}

/// Fits the nuisances with the stated noise, or that which third differences show; a stated noise
/// that is clearly too small is raised.
fn weighted_null_fit(
    plan: &Arc<Plan>,
    nominal: &dyn Simulator,
    stated: &[Option<f64>],
) -> Result<NullFit, FitError> {
    let guess = |c: usize| {
        let signal = measured(plan, c);
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
pub(super) fn inspect_all(
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
        findings.extend(short(null.simulator(), &null.plan().logs[i], i + 1));
    }
    Ok(findings)
}

/// A log that ends before the plant has forgotten where it started.
fn short(simulator: &dyn Simulator, log: &Log, number: usize) -> Option<Finding> {
    let theta: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
    let x0: Vec<f64> = simulator.initial().iter().map(|state| state.value).collect();
    let ts = simulator.ts().seconds();
    let memory = ts * dominant_time_constant(simulator, &theta, &x0, log)?;
    let seconds = ts * log.samples() as f64;
    let channel = simulator.outputs().first()?.name.clone();
    let defect = Defect::Short { seconds, memory };
    (seconds < memory).then_some(Finding { log: number, channel, defect })
}
