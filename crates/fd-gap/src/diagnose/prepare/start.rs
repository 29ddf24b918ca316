//! Logs that begin in motion: their states at the start are not where the model says.
//!
//! A log that was cut out of a longer run does not begin at rest. Held to the stated start, the fit spends its
//! parameters on the transient, and an effect that mimics a transient is blamed. With free starts, on the other
//! hand, what an integrator is off by is no finding any more. So both are tried where the beginnings speak for
//! motion, and the plainer reading is kept unless the other explains clearly more.

use std::sync::Arc;

use super::{Prepared, noise::KnownNoise, weighted_null_fit};
use crate::{
    diagnose::{
        case::Case,
        settings::{Beginning, Settings},
    },
    fit::{FitError, NullFit, Plan},
    quality::EXPLAINED,
    shrink::SURE,
};

/// Part of a log within which a start is forgotten …
const BEGINNING: f64 = 1.0 / 3.0;
/// … and the share of the gain that must lie there. What a free start gains all along the log, as the
/// offset of an integrator does, may as well be an effect …
const AT_THE_BEGINNING: f64 = 0.8;
/// … unless free starts alone explain the log, or leave no more than this part of the squares of some output: what hardly damps
/// never forgets how it began.
const MOST: f64 = 0.1;
/// The first samples of a log, …
const FIRST: usize = 3;
/// … which contradict the stated start when all are off by this many times the noise.
const OFF: f64 = 6.0;

/// The same logs with free starts, if their beginnings speak for motion: an F-test of what the free starts of
/// the model without any effect gain, which need not come near the noise; or if a setting does.
pub(in crate::diagnose) fn in_motion(
    prepared: &Prepared,
    case: &Case<'_>,
    settings: &Settings,
) -> Result<Option<Prepared>, FitError> {
    if settings.without.free_starts || settings.beginning == Beginning::AsStated {
        return Ok(None);
    }
    let simulator =
        case.nominal.patched(&prepared.model, prepared.null.problem.simulator().ts())?;
    let logs = prepared.null.problem.plan().logs.iter().map(|log| log.clone().in_motion());
    // Too short for so many unknowns, or lost from everywhere: then the log begins where it is said to.
    let Ok(plan) = Plan::of_logs(&*simulator, logs.collect(), settings.horizon) else {
        return Ok(None);
    };
    let KnownNoise { stated, grids, spread, .. } = &prepared.noise;
    let Ok(null) = weighted_null_fit(&Arc::new(plan), &*simulator, stated, grids, spread) else {
        return Ok(None);
    };
    let speaks =
        || begins_in_motion(&prepared.null, &null) || begins_elsewhere(&prepared.null, &null);
    if settings.beginning == Beginning::Either && !speaks() {
        return Ok(None);
    }
    let mut noise = prepared.noise.clone();
    noise.sigma.clone_from(&null.problem.weights().sigma);
    Ok(Some(Prepared { model: prepared.model.clone(), null, noise }))
}

/// Squares of the errors of an output, in the noise of the stated starts.
#[derive(Clone, Copy, Debug, Default)]
struct Squares {
    /// In the beginnings of all logs.
    early: f64,
    all: f64,
    samples: f64,
}

impl Squares {
    /// Per output; `None` when the simulation diverges.
    fn of(fit: &NullFit, sigma: &[f64]) -> Option<Vec<Self>> {
        let errors = fit.problem.clone().errors(&fit.minimum.z)?;
        let plan = fit.problem.plan();
        let of = |((signals, own), common): ((&Vec<Vec<f64>>, &f64), &f64)| {
            let mut squares = Self::default();
            for (signal, segment) in signals.iter().zip(plan.segments()) {
                let end = BEGINNING * plan.logs[segment.log].samples() as f64;
                for (k, e) in signal.iter().enumerate().filter(|(_, e)| e.is_finite()) {
                    let square = (e * own / common).powi(2);
                    squares.early += if ((segment.from + k) as f64) < end { square } else { 0.0 };
                    squares.all += square;
                    squares.samples += 1.0;
                }
            }
            squares
        };
        Some(errors.iter().zip(&fit.problem.weights().sigma).zip(sigma).map(of).collect())
    }

    /// Whether they are near those of noise.
    fn are_noise(&self) -> bool {
        self.all < EXPLAINED * EXPLAINED * self.samples
    }

    fn sum(outputs: &[Self]) -> Self {
        outputs.iter().fold(Self::default(), |sum, one| Self {
            early: sum.early + one.early,
            all: sum.all + one.all,
            samples: sum.samples + one.samples,
        })
    }
}

/// Whether the first samples of an output are off, all to one side, with the stated start, and not with a free one: so
/// they are, too, where a sensor is wrong, but an effect on the plant takes time.
fn begins_elsewhere(stated: &NullFit, free: &NullFit) -> bool {
    // By log and output, the least that the first samples are off, to the side where they are.
    let off = |fit: &NullFit| -> Option<Vec<f64>> {
        let errors = fit.problem.clone().errors(&fit.minimum.z)?;
        let begin = |signals: &Vec<Vec<f64>>| -> Vec<f64> {
            let segments = fit.problem.plan().segments().iter().zip(signals);
            let first = segments.filter(|(segment, _)| segment.from == 0).map(|(_, signal)| {
                let mut samples = signal.iter().filter(|e| e.is_finite()).take(FIRST);
                let Some(first) = samples.next() else { return 0.0 };
                samples.fold(first.abs(), |least, e| least.min(e * first.signum()))
            });
            first.collect()
        };
        Some(errors.iter().flat_map(begin).collect())
    };
    let (Some(stated), Some(free)) = (off(stated), off(free)) else { return false };
    stated.iter().zip(&free).any(|(stated, free)| OFF < *stated && *free < OFF)
}

/// Whether free starts explain so much more, and that in the beginning, that the logs cannot have begun where
/// the model says.
fn begins_in_motion(stated: &NullFit, free: &NullFit) -> bool {
    let sigma = &stated.problem.weights().sigma;
    let (Some(before), Some(after)) = (Squares::of(stated, sigma), Squares::of(free, sigma)) else {
        return false;
    };
    let [sum_before, sum_after] = [Squares::sum(&before), Squares::sum(&after)];
    let n = stated.problem.plan().measured() as f64;
    let unknowns = free.problem.plan().own_variables().count() as f64;
    let gain = sum_before.all - sum_after.all;
    let is_early = AT_THE_BEGINNING * gain < sum_before.early - sum_after.early;
    // Of one output, as of a position that only integrates, while another one shows something else.
    let is_most = before.iter().zip(&after).any(|(before, after)| after.all < MOST * before.all);
    (is_early || sum_after.are_noise() || is_most)
        && unknowns * (n.ln() + SURE) * sum_after.all < n * gain
}
