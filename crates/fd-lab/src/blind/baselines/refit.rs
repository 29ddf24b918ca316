//! All parameters refitted within ten times their tolerance: what a parameter estimator does.

use std::sync::Arc;

use fd_gap::fit::{Horizon, Plan, Weights, null_fit};
use fd_sim::{
    model::{LoadError, Model},
    simulate::EquationSimulator,
};

use super::{
    bench::parameters,
    bench::{Baseline, Bench},
};
use crate::blind::error::BlindError;

/// How much wider the tolerances are.
const WIDER: f64 = 10.0;
/// Tolerances by which a parameter must be off to be blamed.
const BLAMED: f64 = 2.0;

pub(super) fn refit(bench: &Bench<'_>) -> Result<Baseline, BlindError> {
    let mut draft = bench.model.clone().into_draft();
    for parameter in &mut draft.parameters {
        parameter.tolerance *= WIDER;
    }
    let wide = Model::try_from(draft).map_err(|error| BlindError::Model {
        error: Box::new(LoadError::Model { file: "the wide model".to_owned(), error }),
    })?;
    let simulator = EquationSimulator::<f64>::at(&wide, bench.train.ts())?;
    let logs = std::slice::from_ref(bench.train);
    let plan = Arc::new(Plan::new(&simulator, logs, Horizon::FreeRun)?);
    let fit = null_fit(&plan, &simulator, &Weights::white(bench.sigma.clone()))?;
    let values = parameters(&fit);
    let off = |(name, value): &(String, f64)| {
        let nominal = bench.model.parameter(name)?;
        let tolerance = nominal.tolerance * nominal.value.abs();
        Some((name.clone(), (value - nominal.value).abs() / tolerance))
    };
    let farthest = values.iter().filter_map(off).max_by(|a, b| a.1.total_cmp(&b.1));
    let named = farthest
        .filter(|(_, tolerances)| BLAMED < *tolerances)
        .map(|(name, _)| ("parameter-error".to_owned(), name));
    let after = bench.held_out_errors(&simulator, &simulator, &values)?;
    Ok(Baseline { named, closed: after.and_then(|after| bench.closed(&after)) })
}
