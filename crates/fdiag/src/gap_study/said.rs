//! A diagnosis as a simulator that forecasts.

use fd_gap::{
    diagnose::Explanation,
    fit::{FitError, Horizon, Log},
    shrink::{Paths, Settled, forecast_errors},
};
use fd_model::SampleTime;
use fd_sim::simulate::{Nominal, Simulator};

/// A model with its parameters settled.
pub(super) struct Said {
    simulator: Box<dyn Simulator>,
    nuisances: Vec<(String, f64)>,
}

impl Said {
    /// The model of an explanation, with the parameters that it has found.
    pub(super) fn of(
        nominal: &dyn Nominal,
        said: &Explanation,
        ts: SampleTime,
    ) -> Result<Self, FitError> {
        let nuisances = said.nuisances.iter().map(|n| (n.name.clone(), n.value)).collect();
        Ok(Self { simulator: nominal.patched(&said.model, ts)?, nuisances })
    }

    /// Errors of forecasts of a log, as [`forecast_errors`] gives them; `plain` is the model as it came.
    pub(super) fn errors(
        &self,
        plain: &dyn Simulator,
        log: &Log,
        horizon: Horizon,
        sigma: &[f64],
    ) -> Result<Option<Vec<Vec<Vec<f64>>>>, FitError> {
        let Self { simulator, nuisances } = self;
        let settled =
            Settled { simulator: &**simulator, nuisances, effects: &[], paths: Paths::AsFitted };
        forecast_errors(plain, settled, std::slice::from_ref(log), horizon, sigma)
    }
}
