//! Before any candidate is tried: the logs, the noise, the fit of the nuisances.

mod chance;
pub(super) mod noise;
pub(super) mod start;
pub(super) mod step;

use std::sync::Arc;

use fd_model::SampleTime;
use fd_sim::{
    model::Model,
    simulate::{EquationSimulator, Simulator},
};

use self::{noise::KnownNoise, step::with_step};
use super::case::Case;
use crate::{
    evidence::of_rounding,
    fit::{FitError, Horizon, Log, NullFit, Plan, Weights, null_fit},
    quality::{AT_THE_NOISE, grid_step, robust_third_difference_floor},
};

/// A stated noise is never raised by more than this, whatever third differences show.
const RAISED: f64 = 4.0;

/// What a diagnosis begins with: the logs, what is known of their noise, and the fit of the model
/// without any effect.
#[derive(Debug)]
pub(crate) struct Prepared {
    /// The nominal model, its integration step pinned.
    pub(super) model: Model,
    /// The fit without any effect, which has the logs.
    pub null: NullFit,
    /// What is known of the noise.
    pub(super) noise: KnownNoise,
}

/// Cuts the logs and fits the nuisances.
pub(crate) fn prepare(case: &Case<'_>, horizon: Horizon) -> Result<Prepared, FitError> {
    prepared(case, None, horizon)
}

/// The same with this integration step.
pub(super) fn prepared(
    case: &Case<'_>,
    step: Option<f64>,
    horizon: Horizon,
) -> Result<Prepared, FitError> {
    let ts = case.logs.first().ok_or(FitError::NoLog)?.ts();
    let nominal = case.nominal.model();
    let model = step.map_or_else(|| pinned(nominal, ts), |step| with_step(nominal, step));
    let simulator = case.nominal.patched(&model, ts)?;
    let plan = Arc::new(Plan::new(&*simulator, case.logs, horizon)?);
    let mut spread = simulator.spread().to_vec();
    spread.resize(model.outputs.len(), 0.0);
    // A stated noise is that of the logs.
    let said = model.outputs.iter().map(|output| output.noise.filter(|noise| 0.0 < *noise));
    let stated: Vec<Option<f64>> =
        said.zip(&spread).map(|(said, spread)| Some(said?.hypot(*spread))).collect();
    let grids: Vec<Option<f64>> =
        (0..stated.len()).map(|c| grid_step(&measured(&plan, c))).collect();
    let null = weighted_null_fit(&plan, &*simulator, &stated, &grids, &spread)?;
    let sigma = null.problem.weights().sigma.clone();
    let slow = vec![false; sigma.len()];
    Ok(Prepared { model, null, noise: KnownNoise { stated, grids, spread, sigma, slow } })
}

/// The model with the integration step that it has with its nominal parameters, whatever they will
/// be.
fn pinned(model: &Model, ts: SampleTime) -> Model {
    let Ok(simulator) = EquationSimulator::<f64>::at(model, ts) else { return model.clone() };
    with_step(model, ts.seconds() / simulator.substeps() as f64)
}

/// An output in all logs, one after the other, with a hole between them.
fn measured(plan: &Plan, output: usize) -> Vec<f64> {
    let column =
        |log: &Log| -> Vec<f64> { log.y.iter().skip(output).step_by(log.ny).copied().collect() };
    plan.logs.iter().map(column).collect::<Vec<_>>().join(&f64::NAN)
}

/// Fits the nuisances with the stated noise, or that which third differences show; a stated noise
/// that is clearly too small is raised. One that is not stated is at least the `spread` of the simulator.
fn weighted_null_fit(
    plan: &Arc<Plan>,
    nominal: &dyn Simulator,
    stated: &[Option<f64>],
    grids: &[Option<f64>],
    spread: &[f64],
) -> Result<NullFit, FitError> {
    let guess = |c: usize| {
        let signal = measured(plan, c);
        let largest = signal.iter().filter(|v| v.is_finite()).fold(0.0_f64, |m, v| m.max(v.abs()));
        // A perfectly smooth signal still has rounding errors.
        let smallest = (1e-9 * largest).max(f64::MIN_POSITIVE);
        robust_third_difference_floor(&signal).unwrap_or(smallest).max(smallest)
    };
    let least = |c: usize| {
        let rounding = grids[c].map_or(0.0, of_rounding);
        if stated[c].is_some() { rounding } else { rounding.hypot(spread[c]) }
    };
    let rounding: Vec<f64> = (0..grids.len()).map(least).collect();
    // What rounding adds to a noise that does not hide the grid.
    let rounded = |sigma: f64, c: usize| {
        if sigma < rounding[c] { sigma.hypot(rounding[c]) } else { sigma }
    };
    let sigma =
        stated.iter().enumerate().map(|(c, stated)| rounded(stated.unwrap_or_else(|| guess(c)), c));
    let first = null_fit(plan, nominal, &Weights::white(sigma.collect()))?;
    let mut problem = first.problem.clone();
    let errors = problem.errors(&first.minimum.z).ok_or(FitError::Diverged)?;
    let old = &first.problem.weights().sigma;
    let new: Vec<f64> = errors
        .iter()
        .zip(old)
        .zip(stated)
        .enumerate()
        .map(|(c, ((signals, old), stated))| {
            let shown =
                robust_third_difference_floor(&signals.join(&f64::NAN)).unwrap_or(1.0) * old;
            let sigma = match stated {
                Some(stated) if shown <= AT_THE_NOISE * stated => *stated,
                Some(stated) => shown.min(RAISED * stated),
                None => shown.max(1e-3 * old),
            };
            // The lattice of a log bounds its noise from below.
            if sigma < rounding[c] { rounded(stated.unwrap_or(0.0), c) } else { sigma }
        })
        .collect();
    if new == *old { Ok(first) } else { null_fit(plan, nominal, &Weights::white(new)) }
}
