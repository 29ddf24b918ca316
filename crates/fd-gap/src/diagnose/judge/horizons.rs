//! Horizons for logs of which no model reaches the noise.

use fd_sim::simulate::Simulator;

use crate::{
    diagnose::weigh::explain::nuisances,
    fit::{Horizon, Log, Minimum, NullFit, Problem},
    shrink::{dominant_time_constant, gap_per_output, horizons},
};

/// A free run whose error is above this part of the signal is lost.
const LOST: f64 = 0.5;

/// Whether a simulation with these errors has little to do with some output.
pub(super) fn is_lost(errors: &[Vec<Vec<f64>>], problem: &Problem) -> bool {
    let logs = &problem.plan().logs;
    gap_per_output(errors).iter().zip(&problem.weights().sigma).enumerate().any(
        |(c, (gap, sigma))| {
            let each = logs.iter().flat_map(|log| log.y.iter().skip(c).step_by(log.ny));
            let measured = each.copied().filter(|value| value.is_finite());
            let [_, spread] = fd_numeric::mean_and_deviation(measured);
            LOST * spread < gap * sigma
        },
    )
}

/// The horizons at which the refitted model is to be judged, and fitted in windows: the middle one.
pub(in crate::diagnose) fn memory(
    simulator: &dyn Simulator,
    null: &NullFit,
    held_out: &[Log],
) -> Vec<Horizon> {
    let Minimum { z, .. } = &null.minimum;
    let refitted = nuisances(&null.problem, z);
    let parameters = simulator.parameters().iter();
    let value = |p: &fd_sim::model::Parameter| {
        let refitted = refitted.iter().find(|nuisance| nuisance.name == p.name);
        refitted.map_or(p.value, |nuisance| nuisance.value)
    };
    let theta: Vec<f64> = parameters.map(value).collect();
    let x0 = null.problem.start_of(0, z);
    let logs = &null.problem.plan().logs;
    let time = dominant_time_constant(simulator, &theta, &x0, &logs[0]);
    let shortest = logs.iter().chain(held_out).map(Log::samples).min().unwrap_or(0);
    horizons(time, simulator.initial().len(), shortest)
}

/// A horizon for fits: the middle one.
pub(super) fn windows(horizons: &[Horizon]) -> Horizon {
    let windows = horizons.iter().rev().find(|h| matches!(h, Horizon::Windows { .. }));
    windows.copied().unwrap_or(Horizon::FreeRun)
}
