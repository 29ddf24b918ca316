//! Before any candidate is tried: the noise, the fit of the nuisances, the quality of the logs.

use std::sync::Arc;

use fd_model::Record;

use crate::{
    fit::{FitError, NullFit, Plan, Problem, Weights, null_fit},
    quality::{Finding, inspect, robust_third_difference_floor},
    simulate::Simulator,
};

/// A stated noise is believed up to this factor below what third differences show …
const BELIEVED: f64 = 1.25;
/// … and never raised by more than this.
const RAISED: f64 = 4.0;

/// Fits the nuisances with the stated noise, or that which third differences show; a stated noise
/// that is clearly too small is raised.
pub(super) fn weighted_null_fit(
    plan: &Arc<Plan>,
    nominal: &dyn Simulator,
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
    }
    Ok(findings)
}
