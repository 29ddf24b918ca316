//! Simpler methods on the same logs, for comparison.

mod bench;
mod black_box;
mod refit;
mod sparse;

use fd_gap::fit::Log;
use fd_model::Record;
use fd_sim::{model::Model, simulate::EquationSimulator};
use serde::{Deserialize, Serialize};

pub use self::bench::Baseline;
use self::bench::{Bench, parameters};
use super::{error::BlindError, refit::null};

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
