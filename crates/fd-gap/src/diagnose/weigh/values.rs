//! A fitted model with its values, as forecasts take it.

use fd_sim::simulate::Simulator;

use super::explain::nuisances;
use crate::{
    fit::{Minimum, Problem, Variable},
    shrink::{Paths, Settled},
};

/// A fitted model with its values.
#[derive(Clone, Debug)]
pub(crate) struct FittedValues<'a> {
    simulator: &'a dyn Simulator,
    nuisances: Vec<(String, f64)>,
    effects: Vec<(Variable, f64)>,
    paths: Paths,
}

impl<'a> FittedValues<'a> {
    pub(crate) fn of(problem: &'a Problem, at: &Minimum) -> Self {
        let values = problem.effect_values(&at.z);
        Self {
            simulator: problem.simulator(),
            nuisances: nuisances(problem, &at.z).into_iter().map(|n| (n.name, n.value)).collect(),
            effects: problem.effects().iter().cloned().zip(values).collect(),
            paths: Paths::AsFitted,
        }
    }

    /// The same values of another simulator.
    pub(in crate::diagnose) fn on(self, simulator: &'a dyn Simulator) -> Self {
        Self { simulator, ..self }
    }

    /// The same values, with this made of paths over time.
    pub(in crate::diagnose) fn with_paths(self, paths: Paths) -> Self {
        Self { paths, ..self }
    }

    pub(crate) fn settled(&self) -> Settled<'_> {
        let Self { simulator, nuisances, effects, paths } = self;
        Settled { simulator: *simulator, nuisances, effects, paths: *paths }
    }
}
