//! The nonlinear engine as state equations, for filters.

use fd_core::{IoDims, stage::Plant};
use fd_jetengine::{
    EngineError,
    engine17::{Engine17, MEASURED, NX, Parameters, Sampled, state_channels},
};
use fd_sim::simulate::Initial;

use super::EngineKnowledge;

/// The engine in physical units, with some of its outputs measured: what a filter asks about.
#[derive(Clone, Debug)]
pub(crate) struct EngineEquations {
    plant: Sampled<Engine17<f64>, NX>,
    /// States that are measured.
    measured: Vec<usize>,
}

impl EngineEquations {
    /// The engine that is known so well, and the states of its equilibrium.
    pub(crate) fn new(known: &EngineKnowledge) -> Result<(Self, Vec<Initial>), EngineError> {
        let engine = Engine17::new(&Parameters::default())?;
        let trim = engine.trim(known.fuel)?;
        let states = state_channels().into_iter().zip(trim.x);
        let states =
            states.map(|(channel, value)| Initial { channel, value, tolerance: None }).collect();
        let measured = known.outputs.iter().filter_map(|i| MEASURED.get(*i).copied()).collect();
        Ok((
            Self { plant: Sampled::with_longest_step(engine, known.ts, known.step), measured },
            states,
        ))
    }
}

impl Plant<f64> for EngineEquations {
    fn nx(&self) -> usize {
        NX
    }

    fn io(&self) -> IoDims {
        IoDims { nu: 1, ny: self.measured.len() }
    }

    fn advance(&self, x: &[f64], u: &[f64], x_next: &mut [f64]) {
        self.plant.advance(x, u, x_next);
    }

    fn output(&self, x: &[f64], _u: &[f64], y: &mut [f64]) {
        y.iter_mut().zip(&self.measured).for_each(|(y, state)| *y = x[*state]);
    }
}
