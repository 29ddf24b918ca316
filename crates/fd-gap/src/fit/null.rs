//! The fit without any effect: nuisances alone.

use std::sync::Arc;

use fd_sim::simulate::Simulator;

use super::{
    error::FitError,
    layout::LeastSquares,
    levenberg::{Minimum, Search, minimise, minimise_all},
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
/// from fits to the first 100, 250 and 500 samples, and the better result is kept. Where runs are dear all that is done
/// on the stand-in, and goes on on the simulator from there, if that is better than where the model is.
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
    if !problem.begins_on_stand_in() {
        let minimum = lowest(&mut problem, simulator, build)?.shared(&problem);
        return Ok(NullFit { problem, minimum });
    }
    let stood_in = |plan| build(plan).map(Problem::on_stand_in);
    let found = lowest(&mut problem.clone().on_stand_in(), simulator, stood_in);
    let starts = std::iter::once(origin(&problem)).chain(found.ok().map(|found| found.z));
    let starts: Vec<Vec<f64>> = starts.collect();
    let look = Search { iterations: 0, ..problem.search() };
    let looks = minimise_all(&mut problem, &starts, None, look).into_iter().flatten();
    let start = looks.min_by(|a, b| a.cost.total_cmp(&b.cost)).ok_or(FitError::Diverged)?;
    let search = problem.search();
    let minimum = minimise(&mut problem, &start.z, None, search).unwrap_or(start).shared(&problem);
    Ok(NullFit { problem, minimum })
}

/// Everything as the model says.
fn origin(problem: &Problem) -> Vec<f64> {
    vec![0.0; problem.layout().unknowns()]
}

/// The lowest minimum of a problem, of which others with shorter logs are made.
fn lowest(
    problem: &mut Problem,
    simulator: &dyn Simulator,
    build: impl Fn(Arc<Plan>) -> Result<Problem, FitError>,
) -> Result<Minimum, FitError> {
    let fit = |problem: &mut Problem, z: &[f64]| {
        let search = problem.search();
        minimise(problem, z, None, search)
    };
    let plan = Arc::clone(problem.plan());
    let mut z = origin(problem);
    let mut best = fit(problem, &z).ok_or(FitError::Diverged)?;
    let is_free_run = plan.segments.len() == plan.logs.len();
    if is_free_run && FAR * (plan.measured() as f64) < best.cost {
        for samples in PREFIXES {
            let logs: Vec<_> = plan.logs.iter().map(|log| log.prefix(samples)).collect();
            let Ok(short) = Plan::of_logs(simulator, logs, Horizon::FreeRun) else { continue };
            if let Some(minimum) = fit(&mut build(Arc::new(short))?, &z) {
                z = minimum.z;
            }
        }
        if let Some(other) = fit(problem, &z).filter(|other| other.cost < best.cost) {
            best = other;
        }
    }
    Ok(best)
}
