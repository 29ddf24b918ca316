//! The fit without any effect: nuisances alone.

use std::sync::Arc;

use fd_sim::simulate::Simulator;

use super::{
    error::FitError,
    layout::LeastSquares,
    levenberg::{Minimum, minimise},
    plan::{Horizon, Plan},
    problem::Problem,
    weights::Weights,
};

/// Samples from which a fit works its way to the whole log.
const PREFIXES: [usize; 3] = [100, 250, 500];
/// Mean square, in units of the noise, from which a fit may sit in the wrong valley.
const FAR: f64 = 25.0;

/// The fit without any effect.
#[derive(Clone, Debug)]
pub struct NullFit {
    /// Simulator against logs.
    pub problem: Problem,
    /// Where the fit ended, with slopes of that place.
    pub minimum: Minimum,
}

/// Fits the nuisances. If that leaves errors far above the noise in free runs of whole logs, it is tried again
/// from fits to the first 100, 250 and 500 samples, and the better result is kept.
///
/// # Errors
///
/// Returns an error when the simulator does not have what the plan needs, or diverges at the
/// start.
pub fn null_fit(
    plan: &Arc<Plan>,
    simulator: &dyn Simulator,
    weights: &Weights,
) -> Result<NullFit, FitError> {
    let build = |plan: Arc<Plan>| Problem::new(plan, simulator.boxed(), vec![], weights.clone());
    let mut problem = build(plan.clone())?;
    let origin = vec![0.0; problem.layout().unknowns()];
    let fit = |problem: &mut Problem, z: &[f64]| {
        let search = problem.search();
        minimise(problem, z, None, search)
    };
    let mut best = fit(&mut problem, &origin).ok_or(FitError::Diverged)?;
    let is_free_run = plan.segments.len() == plan.logs.len();
    if is_free_run && FAR * (plan.measured() as f64) < best.cost {
        let mut z = origin;
        for samples in PREFIXES {
            let logs: Vec<_> = plan.logs.iter().map(|log| log.prefix(samples)).collect();
            let Ok(short) = Plan::of_logs(simulator, logs, Horizon::FreeRun) else { continue };
            if let Some(minimum) = fit(&mut build(Arc::new(short))?, &z) {
                z = minimum.z;
            }
        }
        if let Some(other) = fit(&mut problem, &z).filter(|other| other.cost < best.cost) {
            best = other;
        }
    }
    Ok(NullFit { problem, minimum: best })
}
