//! Findings: what is wrong with the logs.

use fd_model::Record;
use fd_sim::simulate::{Initial, Simulator};

use crate::{
    diagnose::result::Start,
    fit::{FitError, Log, Plan, Problem},
    quality::{Defect, Finding, inspect},
    shrink::dominant_time_constant,
};

/// Findings in all logs, of which `known` inputs come from outside, with the errors that the null fit has left in each.
pub(super) fn findings(
    logs: &[Record],
    null: &Problem,
    known: usize,
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
        findings.extend(inspect(log, null.simulator(), known, stated, Some(&left), i + 1)?);
        findings.extend(short(null.simulator(), &null.plan().logs[i], i + 1));
    }
    Ok(findings)
}

/// States that a log which begins in motion does not have where the model says, by more than this many tolerances.
const ELSEWHERE: f64 = 4.0;

/// Where logs begin that do not begin where the model says.
pub(super) fn elsewhere(plan: &Plan, starts: &[Start], initial: &[Initial]) -> Vec<Finding> {
    let logs = starts.iter().filter(|s| s.from == 0 && plan.logs[s.log].is_in_motion);
    let of_log = logs.flat_map(|log| {
        let states = log.state.iter().zip(initial);
        let moved = states.filter(|(start, stated)| {
            ELSEWHERE * stated.tolerance.unwrap_or(0.0) < (**start - stated.value).abs()
        });
        moved.map(|(start, stated)| Finding {
            log: log.log + 1,
            channel: stated.channel.name.clone(),
            defect: Defect::Elsewhere {
                start: *start,
                stated: stated.value,
                unit: stated.channel.unit.clone(),
            },
        })
    });
    of_log.collect()
}

/// Outputs that a controller makes of a log.
pub(super) fn of_controller(log: usize, commanded: &[String]) -> impl Iterator<Item = Finding> {
    commanded.iter().map(move |name| Finding {
        log,
        channel: name.clone(),
        defect: Defect::Commanded,
    })
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
