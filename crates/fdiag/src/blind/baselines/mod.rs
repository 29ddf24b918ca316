//! Simpler methods on the same logs, for comparison.

use fd_gap::{
    fit::{FitError, Horizon, Log},
    model::Model,
    shrink::{Settled, closed, forecast_errors},
    simulate::{EquationSimulator, Simulator},
};
use fd_model::Record;
use serde::{Deserialize, Serialize};

use super::{error::BlindError, oracle::null};

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

/// The parameters of the null fit, and what the other methods say.
pub(super) fn all(
    model: &Model,
    train: &Record,
    _held_out: &Record,
    _with_baselines: bool,
) -> Result<(Vec<(String, f64)>, Option<Baselines>), BlindError> {
    let null = null(model, train)?;
    let names = null.problem.plan().nuisances().iter().map(|v| v.name.clone());
    let values = null.problem.nuisance_values(&null.minimum.z);
    let refit: Vec<(String, f64)> = names.zip(values).collect();
    Ok((refit, None))
}
