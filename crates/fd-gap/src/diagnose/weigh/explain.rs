//! Models with all values settled, and what they make of the training logs.

use fd_sim::model::{Model, Parameter};

use crate::{
    diagnose::result::{Explanation, Nuisance, Start},
    fit::{FitError, LeastSquares, Problem, Variable},
    shrink::gap_per_output,
};

/// A fitted problem, of which `model` is the (patched) model; `None` when its simulation diverges.
pub(in crate::diagnose) fn explain(
    model: &Model,
    problem: &mut Problem,
    z: &[f64],
) -> Option<Explanation> {
    let gap = gap_per_output(&problem.errors(z)?);
    let outputs = problem.outputs(z)?;
    let segments = problem.plan().segments().to_vec();
    let starts = segments.iter().enumerate().map(|(s, segment)| Start {
        log: segment.log,
        from: segment.from,
        state: problem.start_of(s, z),
    });
    let starts = starts.collect();
    let (model, nuisances) = (settle(model, problem, z), nuisances(problem, z));
    Some(Explanation { model, nuisances, starts, outputs, gap })
}

/// The refitted parameters of the nominal model.
pub(in crate::diagnose) fn nuisances(problem: &Problem, z: &[f64]) -> Vec<Nuisance> {
    let nuisance = |(variable, z): (&Variable, &f64)| Nuisance {
        name: variable.name.clone(),
        value: variable.value(*z),
        deviation: z * variable.precision().sqrt(),
    };
    problem.plan().nuisances().iter().zip(z).map(nuisance).collect()
}

/// The nominal model as it came, against the logs of a problem.
pub(in crate::diagnose) fn nominal_explanation(
    model: &Model,
    problem: &Problem,
) -> Result<Explanation, FitError> {
    let mut problem = problem.clone();
    let z = vec![0.0; problem.layout().unknowns()];
    explain(model, &mut problem, &z).ok_or(FitError::Diverged)
}

/// The model with its parameters, and the initial state of the first run, as they were fitted.
pub(crate) fn settle(model: &Model, problem: &Problem, z: &[f64]) -> Model {
    let mut draft = model.clone().into_draft();
    let shared = problem.plan().nuisances().iter().chain(problem.effects());
    for (variable, z) in shared.zip(z) {
        let value = variable.value(*z);
        if let Some(parameter) = draft.parameters.iter_mut().find(|p| p.name == variable.name) {
            *parameter = settled(parameter, value);
        }
    }
    let names = problem.simulator().initial().iter().map(|state| state.channel.name.clone());
    for (name, value) in names.zip(problem.start_of(0, z)) {
        if let Some(state) = draft.states.iter_mut().find(|state| state.name == name) {
            state.initial = value;
        }
    }
    // Values within the bounds of a correct model make a correct model.
    Model::try_from(draft).unwrap_or_else(|_| model.clone())
}

/// A parameter at another value, which its bounds then contain.
fn settled(parameter: &Parameter, value: f64) -> Parameter {
    let bounds = parameter.bounds.map(|[low, high]| [low.min(value), high.max(value)]);
    Parameter { value, bounds, ..parameter.clone() }
}
