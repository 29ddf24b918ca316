//! A case as the simpler methods see it, and what one of them says.

use fd_gap::{
    fit::{FitError, Horizon, LeastSquares, Log, NullFit},
    shrink::{Errors, Paths, Settled, forecast_errors, gap},
};
use fd_model::Record;
use fd_sim::{
    model::Model,
    simulate::{EquationSimulator, Simulator},
};
use serde::{Deserialize, Serialize};

/// A gap that is less than this above the noise, in sigma, cannot be shared out.
pub(super) const REDUCIBLE: f64 = 0.01;

/// What one method says.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Baseline {
    /// Label and site of the cause that it names, if it names one.
    pub named: Option<(String, String)>,
    /// Share of the held-out gap left by the null fit that it closes.
    pub closed: Option<f64>,
}

/// A case as the simpler methods see it.
pub(super) struct Bench<'a> {
    pub model: &'a Model,
    pub nominal: EquationSimulator,
    pub train: &'a Record,
    pub held_out: &'a Record,
    pub held_out_log: Log,
    pub null: NullFit,
    /// Parameters of the null fit.
    pub refit: Vec<(String, f64)>,
    pub sigma: Vec<f64>,
    /// Held-out errors of the null fit.
    pub before: Vec<Vec<Vec<f64>>>,
}

impl Bench<'_> {
    /// Errors of forecasts of the held-out run, in sigma; `values` are within the tolerances of
    /// `nominal`.
    pub(super) fn held_out_errors(
        &self,
        nominal: &dyn Simulator,
        simulator: &dyn Simulator,
        values: &[(String, f64)],
    ) -> Result<Option<Vec<Vec<Vec<f64>>>>, FitError> {
        let settled =
            Settled { simulator, nuisances: values, effects: &[], paths: Paths::AsFitted };
        let logs = std::slice::from_ref(&self.held_out_log);
        forecast_errors(nominal, settled, logs, Horizon::FreeRun, &self.sigma)
    }

    /// The share of the gap above the stated noise that is closed.
    pub(super) fn closed(&self, after: &Errors) -> Option<f64> {
        let (before, after) = (gap(&self.before) - 1.0, gap(after) - 1.0);
        (REDUCIBLE < before).then(|| 1.0 - after / before).filter(|share| share.is_finite())
    }

    /// Measured less simulated, in sigma, row by row, for the null fit on the training run.
    pub(super) fn residual(&self) -> Option<Vec<f64>> {
        let mut problem = self.null.problem.clone();
        debug_assert_eq!(problem.layout().segments.len(), 1, "one free run");
        let errors = problem.errors(&self.null.minimum.z)?;
        let samples = self.train.len();
        Some((0..samples).flat_map(|k| errors.iter().map(move |e| -e[0][k])).collect())
    }
}

/// Values of the parameters of a null fit, by name.
pub(super) fn parameters(null: &NullFit) -> Vec<(String, f64)> {
    let names = null.problem.plan().nuisances().iter().map(|v| v.name.clone());
    names.zip(null.problem.nuisance_values(&null.minimum.z)).collect()
}
