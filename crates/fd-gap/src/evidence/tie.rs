//! Can this log tell two causes apart at all?

use std::sync::Arc;

use crate::fit::{Minimum, Problem, Search, minimise};

/// Distance, in squares of the noise, below which a log does not separate two models.
pub const SEPARATED: f64 = 9.0;

/// Sum of squares, in units of the noise, that remains when `rival` (fitted at `rival_at`) is
/// refitted to the noise-free simulation of `truth` at `at`, with the inputs of the logs. The
/// nuisances of the rival are free within their boxes around those of the truth.
///
/// Infinite when a simulation diverges.
#[must_use]
pub fn distance(truth: &Problem, at: &Minimum, rival: &Problem, rival_at: &Minimum) -> f64 {
    // Whether two models can be told apart is no question to a simulator of which runs are dear.
    let mut truth = truth.clone().on_stand_in();
    let Some(logs) = truth.simulated(&at.z) else { return f64::INFINITY };
    let plan = Arc::new(truth.plan().moved(logs, &truth.nuisance_values(&at.z)));
    let weights = truth.weights().clone();
    let (simulator, effects) = (rival.simulator().boxed(), rival.effects().to_vec());
    let Ok(refit) = Problem::new(plan, simulator, effects, weights) else {
        return f64::INFINITY;
    };
    let mut refit = refit.on_stand_in();
    // From the rival's own fit, and from the truth's nuisances with the rival's effect.
    let effects = rival.effect_values(&rival_at.z);
    let origin = vec![0.0; rival.nuisances(&rival_at.z).len()];
    let moved: Vec<f64> = {
        let values = rival.nuisance_values(&rival_at.z);
        let plan = refit.plan();
        let variables = plan.nuisances().iter().chain(plan.own_variables());
        variables.zip(&values).map(|(variable, value)| variable.scaled(*value)).collect()
    };
    let mut least = f64::INFINITY;
    for nuisances in [moved, origin] {
        let z = refit.place(&nuisances, &effects);
        if let Some(minimum) = minimise(&mut refit, &z, None, Search::default()) {
            least = least.min(minimum.cost);
        }
        if least < SEPARATED {
            break;
        }
    }
    least
}
