//! The plant that a benchmark run watches, linear or not, healthy or with faults.

use std::ops::Range;

use fd_core::stage::Plant;
use fd_jetengine::{
    EngineError,
    engine17::{Engine17, ExtendedEngine, NX, NX_EXTENDED, PerUnit, Sampled, Unmodelled},
};
use fd_model::{Channel, Inputs, Lti, Record, SampleTime, Simulation, SimulationError};

/// One engine in relative deviations from where it stood when it was new.
pub(crate) enum Reality {
    /// Linear; it has no components that could break.
    Linear(Lti<f64>),
    /// The seventeen states, with the state at rest.
    Core(Box<PerUnit<Engine17<f64>, NX>>, [f64; NX]),
    /// The same with dynamics that no model here knows.
    Extended(Box<PerUnit<ExtendedEngine<f64>, NX_EXTENDED>>, [f64; NX_EXTENDED]),
}

impl Reality {
    /// A nonlinear engine at rest at a fuel flow in kg/s, in deviations from the equilibrium of
    /// `new`, which is the same engine before it was worn.
    pub(crate) fn nonlinear(
        new: &Engine17<f64>,
        engine: &Engine17<f64>,
        unmodelled: Option<Unmodelled>,
        fuel: f64,
        ts: SampleTime,
    ) -> Result<Self, EngineError> {
        let (reference, rest) = (new.trim(fuel)?, engine.trim(fuel)?);
        Ok(match unmodelled {
            None => {
                let plant = PerUnit::new(Sampled::new(engine.clone(), ts), reference.x, fuel)?;
                Self::Core(Box::new(plant), relative(&rest.x, &reference.x))
            }
            Some(unmodelled) => {
                let engine = ExtendedEngine::new(engine.clone(), unmodelled)?;
                let (reference, rest) = (engine.equilibrium(&reference), engine.equilibrium(&rest));
                let plant = PerUnit::new(Sampled::new(engine, ts), reference, fuel)?;
                Self::Extended(Box::new(plant), relative(&rest, &reference))
            }
        })
    }

    /// Drives it, from rest unless the simulation has a state to begin with.
    pub(crate) fn run(
        &self,
        mut simulation: Simulation,
        inputs: &Inputs,
        outputs: Vec<Channel>,
    ) -> Result<Record, SimulationError> {
        if simulation.x0.is_empty() {
            simulation.x0 = self.rest();
        }
        match self {
            Self::Linear(plant) => simulation.run(plant, inputs, outputs),
            Self::Core(plant, _) => simulation.run_with_parameters(plant.as_ref(), inputs, outputs),
            Self::Extended(plant, _) => {
                simulation.run_with_parameters(plant.as_ref(), inputs, outputs)
            }
        }
    }

    /// The state before step `k` of a run from rest without faults.
    pub(crate) fn state_at(&self, inputs: &Inputs, k: usize) -> Vec<f64> {
        let mut x = self.rest();
        self.advance(&mut x, inputs, 0..k);
        x
    }

    /// Takes a state through some steps without faults.
    pub(crate) fn advance(&self, x: &mut Vec<f64>, inputs: &Inputs, steps: Range<usize>) {
        let plant: &dyn Plant<f64> = match self {
            Self::Linear(plant) => plant,
            Self::Core(plant, _) => plant.as_ref(),
            Self::Extended(plant, _) => plant.as_ref(),
        };
        let mut next = x.clone();
        for k in steps {
            plant.advance(x, inputs.u(k), &mut next);
            std::mem::swap(x, &mut next);
        }
    }

    pub(crate) fn rest(&self) -> Vec<f64> {
        match self {
            Self::Linear(plant) => vec![0.0; plant.nx()],
            Self::Core(_, rest) => rest.to_vec(),
            Self::Extended(_, rest) => rest.to_vec(),
        }
    }
}

fn relative<const N: usize>(x: &[f64; N], reference: &[f64; N]) -> [f64; N] {
    std::array::from_fn(|i| x[i] / reference[i] - 1.0)
}
