//! Simpler methods on the same logs, for comparison.

mod black_box;
mod refit;
mod sparse;

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

use super::{error::BlindError, refit::null};

/// A gap that is less than this above the noise, in sigma, cannot be shared out.
const REDUCIBLE: f64 = 0.01;

/// What simpler methods say of a case.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Baselines {
    /// A wider refit of all parameters.
    pub refit: Baseline,
    /// Black-box compensation of the residual.
    pub black_box: Baseline,
    /// Sparse regression on residual rates.
    pub sparse: Baseline,
}

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
struct Bench<'a> {
    model: &'a Model,
    nominal: EquationSimulator,
    train: &'a Record,
    held_out: &'a Record,
    held_out_log: Log,
    null: NullFit,
    /// Parameters of the null fit.
    refit: Vec<(String, f64)>,
    sigma: Vec<f64>,
    /// Held-out errors of the null fit.
    before: Vec<Vec<Vec<f64>>>,
}

/// What the simpler methods say.
pub(super) fn all(
    model: &Model,
    train: &Record,
    held_out: &Record,
) -> Result<Baselines, BlindError> {
    let null = null(model, model, std::slice::from_ref(train), 0.0)?;
    let nominal = EquationSimulator::<f64>::at(model, train.ts())?;
    let held_out_log = Log::new(held_out, &nominal, 1)?;
    let mut bench = Bench {
        before: Vec::new(),
        refit: parameters(&null),
        sigma: model.outputs.iter().map(|o| o.noise.unwrap_or(1.0)).collect(),
        model,
        nominal,
        train,
        held_out,
        held_out_log,
        null,
    };
    let before = bench.held_out_errors(&bench.nominal, &bench.nominal, &bench.refit)?;
    let Some(before) = before else { return Ok(Baselines::default()) };
    bench.before = before;
    Ok(Baselines {
        refit: refit::refit(&bench)?,
        black_box: black_box::black_box(&bench)?,
        sparse: sparse::sparse(&bench)?,
    })
}

/// Values of the parameters of a null fit, by name.
fn parameters(null: &NullFit) -> Vec<(String, f64)> {
    let names = null.problem.plan().nuisances().iter().map(|v| v.name.clone());
    names.zip(null.problem.nuisance_values(&null.minimum.z)).collect()
}

impl Bench<'_> {
    /// Errors of forecasts of the held-out run, in sigma; `values` are within the tolerances of
    /// `nominal`.
    fn held_out_errors(
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
    fn closed(&self, after: &Errors) -> Option<f64> {
        let (before, after) = (gap(&self.before) - 1.0, gap(after) - 1.0);
        (REDUCIBLE < before).then(|| 1.0 - after / before).filter(|share| share.is_finite())
    }

    /// Measured less simulated, in sigma, row by row, for the null fit on the training run.
    fn residual(&self) -> Option<Vec<f64>> {
        let mut problem = self.null.problem.clone();
        debug_assert_eq!(problem.layout().segments.len(), 1, "one free run");
        let errors = problem.errors(&self.null.minimum.z)?;
        let samples = self.train.len();
        Some((0..samples).flat_map(|k| errors.iter().map(move |e| -e[0][k])).collect())
    }
}
