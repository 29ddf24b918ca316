//! Plants of which a diagnosis knows only that they step.

use fd_model::SampleTime;
use fd_sim::{
    model::Model,
    outside::{
        Contract, Instance, Lost, Motion, OutsideError, OutsideSimulator, Powers, Source, Start,
    },
    simulate::{EquationSimulator, Shell, Simulator},
};

use super::error::BlindError;

/// How much of a plant can be seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sight {
    /// Outputs and states, as they are.
    States,
    /// Outputs alone, in single precision.
    Outputs,
    /// The same in whole runs only.
    Runs,
}

/// What starts copies of a plant.
#[derive(Clone, Debug)]
struct Plant {
    simulator: Box<dyn Simulator>,
    sight: Sight,
}

impl Source for Plant {
    fn open(&self) -> Result<Box<dyn Instance>, OutsideError> {
        Ok(Box::new(self.clone()))
    }
}

impl Plant {
    /// Inputs and forces of a row.
    fn split<'a>(&self, row: &'a [f64]) -> (&'a [f64], &'a [f64]) {
        row.split_at(self.simulator.inputs().len())
    }
}

impl Instance for Plant {
    fn reset(&mut self, start: Start<'_>) -> Result<(), Lost> {
        self.simulator.start(start.theta, start.x0, start.first);
        Ok(())
    }

    fn measure(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Lost> {
        if !self.simulator.measure(u, y) {
            return Err(Lost::Refused);
        }
        if self.sight != Sight::States {
            for y in y {
                *y = single(*y);
            }
        }
        Ok(())
    }

    fn step(&mut self, row: &[f64], y: &mut [f64], x: &mut [f64]) -> Result<(), Lost> {
        let (u, f) = self.split(row);
        self.simulator.step(u, u, f, y);
        match self.sight {
            Sight::States => x.copy_from_slice(self.simulator.state()),
            Sight::Outputs | Sight::Runs => y.iter_mut().for_each(|y| *y = single(*y)),
        }
        Ok(())
    }
}

/// A value as single precision has it.
#[expect(clippy::cast_possible_truncation, reason = "that is the point")]
fn single(value: f64) -> f64 {
    f64::from(value as f32)
}

/// A plant as a black box in its shell. It tells what a force at a port moves where that is one of its outputs.
pub(super) struct BlackBox {
    pub(super) shell: Shell,
    simulator: OutsideSimulator,
}

impl BlackBox {
    pub(super) fn of(model: &Model, ts: SampleTime, sight: Sight) -> Result<Self, BlindError> {
        let plant = EquationSimulator::<f64>::with_ports(model, ts)?;
        // With delays or a sampled controller it cannot be looked at before it moves on.
        let mut still = vec![0.0; plant.outputs().len()];
        let measure = plant.boxed().measure(&vec![0.0; plant.inputs().len()], &mut still);
        let motion = model.sites.iter().map(|site| {
            let [position, velocity] = [&site.position, &site.velocity].map(|moved| {
                let is_it = |value| moved.as_ref().is_some_and(|moved| moved == value);
                let output = model.outputs.iter().find(|output| is_it(&output.value));
                output.map(|output| output.name.clone())
            });
            Motion { position, velocity }
        });
        let contract = Contract {
            natives: Vec::new(),
            name: model.name.clone(),
            ts,
            inputs: plant.inputs().to_vec(),
            outputs: plant.outputs().to_vec(),
            noise: model.outputs.iter().map(|output| output.noise).collect(),
            parameters: plant.parameters().to_vec(),
            initial: plant.initial().to_vec(),
            ports: plant.ports().to_vec(),
            motion: motion.collect(),
            powers: Powers {
                measure: measure && sight != Sight::Runs,
                states: sight == Sight::States,
                step: sight != Sight::Runs,
                rollout: sight == Sight::Runs,
                ..Powers::default()
            },
        };
        let simulator = OutsideSimulator::new(
            contract,
            Plant { simulator: plant.boxed(), sight },
            rayon::current_num_threads(),
        )?;
        let shell = simulator.shell()?;
        Ok(Self { shell, simulator })
    }

    /// Runs through `samples` that were made so far.
    pub(super) fn runs(&self, samples: usize) -> f64 {
        self.simulator.counts().steps as f64 / samples.max(1) as f64
    }
}
