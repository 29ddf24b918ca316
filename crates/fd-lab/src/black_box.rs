//! Simulators of which a diagnosis knows only that they step, or make whole runs.

use fd_sim::{
    model::Model,
    outside::{
        Contract, Instance, Lost, Motion, OutsideError, OutsideSimulator, Powers, Source, Start,
    },
    simulate::{EquationSimulator, Shell, SimulateError, Simulator},
};

/// How much of a simulator can be seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sight {
    /// Outputs and states, as they are.
    States,
    /// Outputs alone, in single precision.
    Outputs,
    /// The same in whole runs only.
    Runs,
}

/// What starts copies of a simulator.
#[derive(Clone, Debug)]
struct Copies {
    simulator: Box<dyn Simulator>,
    sight: Sight,
}

impl Source for Copies {
    fn open(&self) -> Result<Box<dyn Instance>, OutsideError> {
        Ok(Box::new(self.clone()))
    }
}

impl Copies {
    /// Inputs and forces of a row.
    fn split<'a>(&self, row: &'a [f64]) -> (&'a [f64], &'a [f64]) {
        row.split_at(self.simulator.inputs().len())
    }
}

impl Instance for Copies {
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

/// A simulator as a black box.
pub(crate) struct BlackBox {
    simulator: OutsideSimulator,
}

impl BlackBox {
    /// The `plant` of a model, with its ports. It tells what a force at a port moves where that is one of its outputs.
    pub(crate) fn of_equations(
        model: &Model,
        plant: EquationSimulator,
        sight: Sight,
    ) -> Result<Self, OutsideError> {
        let motion = model.sites.iter().map(|site| {
            let [position, velocity] = [&site.position, &site.velocity].map(|moved| {
                let is_it = |value| moved.as_ref().is_some_and(|moved| moved == value);
                let output = model.outputs.iter().find(|output| is_it(&output.value));
                output.map(|output| output.name.clone())
            });
            Motion { position, velocity }
        });
        let noise = model.outputs.iter().map(|output| output.noise).collect();
        Self::of(&model.name, Box::new(plant), noise, motion.collect(), sight)
    }

    /// Any simulator, with the noise of its outputs and what the forces at its ports move.
    pub(crate) fn of(
        name: &str,
        simulator: Box<dyn Simulator>,
        noise: Vec<Option<f64>>,
        motion: Vec<Motion>,
        sight: Sight,
    ) -> Result<Self, OutsideError> {
        // With delays or a sampled controller it cannot be looked at before it moves on.
        let mut still = vec![0.0; simulator.outputs().len()];
        let measure = simulator.boxed().measure(&vec![0.0; simulator.inputs().len()], &mut still);
        let contract = Contract {
            natives: Vec::new(),
            name: name.to_owned(),
            ts: simulator.ts(),
            inputs: simulator.inputs().to_vec(),
            outputs: simulator.outputs().to_vec(),
            noise,
            parameters: simulator.parameters().to_vec(),
            initial: simulator.initial().to_vec(),
            ports: simulator.ports().to_vec(),
            motion,
            powers: Powers {
                measure: measure && sight != Sight::Runs,
                states: sight == Sight::States,
                step: sight != Sight::Runs,
                rollout: sight == Sight::Runs,
                ..Powers::default()
            },
        };
        let workers = rayon::current_num_threads();
        let simulator = OutsideSimulator::new(contract, Copies { simulator, sight }, workers)?;
        Ok(Self { simulator })
    }

    /// It in its shell.
    ///
    /// # Errors
    ///
    /// Returns an error when a value of the simulator is out of order.
    pub(crate) fn shell(&self) -> Result<Shell, SimulateError> {
        self.simulator.shell()
    }

    /// Runs through `samples` that were made so far.
    pub(crate) fn runs(&self, samples: usize) -> f64 {
        self.simulator.counts().steps as f64 / samples.max(1) as f64
    }
}
