//! Is the integration step short enough for the effects that matter?

use crate::together::each;
use fd_sim::{
    model::{Law, Model},
    simulate::Nominal,
};

use super::{searched::Searched, trial::Trial};
use crate::{
    diagnose::prepare::step::with_step,
    fit::{FitError, Minimum, Problem, null_fit},
    shrink::gap_per_output,
};

/// Largest change of an output that a step of half the length may make, of what the fit leaves of it: of sigma, or of the
/// errors where these are larger. The likelihood does not see more than that: with `n` samples, it moves by `n/2` times the
/// square.
const LARGEST_CHANGE: f64 = 0.2;
/// How often the step is halved at most.
pub(in crate::diagnose) const MOST_HALVINGS: usize = 3;
/// Trials, the best first, of which the step is checked.
const CHECKED: usize = 5;

/// The same search with a shorter integration step: it is halved, and the finalists and the model
/// without any effect are fitted again, until the outputs of the best do not depend on it by more
/// than a fifth of what they leave unexplained. A model that is sampled itself, or a simulator with a step of its own, stays as it is.
pub(super) fn with_short_steps<'a>(
    nominal: &dyn Nominal,
    searched: Searched<'a>,
) -> Result<Searched<'a>, FitError> {
    let Searched { mut model, mut null, mut trials, .. } = searched;
    for _ in 0..MOST_HALVINGS {
        let mut best: Vec<&Trial<'_>> = trials.iter().filter(|trial| trial.is_final).collect();
        best.sort_by(|a, b| a.cost().total_cmp(&b.cost()));
        best.truncate(CHECKED);
        let finalists = best
            .into_iter()
            .filter_map(|trial| Some((&trial.model, &trial.problem, trial.best.as_ref()?)));
        let all = finalists.chain([(&model, &null.problem, &null.minimum)]);
        let step = all
            .into_iter()
            .find_map(|(model, problem, at)| shorter_step(nominal, model, problem, at));
        let Some(step) = step else { break };
        model = with_step(&model, step);
        let simulator = nominal.patched(&model, null.problem.simulator().ts())?;
        null = null_fit(null.problem.plan(), &*simulator, null.problem.weights())?;
        let finalists = trials.iter_mut().filter(|trial| trial.is_final);
        let refined = each(finalists, |trial| trial.refine(nominal, step, &null));
        refined.into_iter().collect::<Result<(), _>>()?;
    }
    Ok(Searched { model, null, trials, ..searched })
}

/// Half the step of a model that was fitted, where the outputs depend on it; `None` where they do not, or where there is none
/// to halve: a model that is sampled itself has that of a sample for its law.
pub(in crate::diagnose) fn shorter_step(
    nominal: &dyn Nominal,
    model: &Model,
    problem: &Problem,
    at: &Minimum,
) -> Option<f64> {
    let is_sampled = !model.all_states().any(|state| matches!(state.law, Law::Derivative(_)));
    let step = model.step.filter(|_| !is_sampled && !nominal.keeps_step())?;
    // What cannot be simulated or diverges with the shorter step is no reason for it.
    let change = change(nominal, &with_step(model, 0.5 * step), problem, at)?;
    (LARGEST_CHANGE < change).then_some(0.5 * step)
}

/// Largest root of the mean square, over outputs, by which the outputs of a fitted problem change with another model: of
/// that of the errors, which are in sigma, and are at least one.
fn change(nominal: &dyn Nominal, other: &Model, problem: &Problem, at: &Minimum) -> Option<f64> {
    let ts = problem.simulator().ts();
    let simulator = nominal.patched(other, ts).ok()?;
    let (plan, weights) = (problem.plan().clone(), problem.weights().clone());
    let mut finer = Problem::new(plan, simulator, problem.effects().to_vec(), weights).ok()?;
    let (mut a, b) = (problem.clone().errors_at(at)?, finer.errors(&at.z)?);
    let left = gap_per_output(&a);
    for (a, b) in a.iter_mut().flatten().flatten().zip(b.iter().flatten().flatten()) {
        *a -= b;
    }
    let of_left = |(change, left): (f64, f64)| change / left.max(1.0);
    Some(gap_per_output(&a).into_iter().zip(left).map(of_left).fold(0.0, f64::max))
}
