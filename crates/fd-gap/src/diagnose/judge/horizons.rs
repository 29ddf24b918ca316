//! Horizons for logs of which no model reaches the noise.

use fd_sim::simulate::Simulator;

use crate::{
    diagnose::weigh::explain::nuisances,
    fit::{Horizon, Log, Minimum, NullFit},
    shrink::{dominant_time_constant, horizons},
};

/// The horizons at which the refitted model is to be judged.
pub(super) fn memory(simulator: &dyn Simulator, null: &NullFit, held_out: &[Log]) -> Vec<Horizon> {
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

/// The horizon of forecasts that are weighed: the middle one. Over longer ones what is unknown does not act linearly.
pub(super) fn windows(horizons: &[Horizon]) -> Horizon {
    let windows = horizons.iter().rev().find(|h| matches!(h, Horizon::Windows { .. }));
    windows.copied().unwrap_or(Horizon::FreeRun)
}
