//! A linear model as a simulator that gets the row of the replays as an input.

use std::{fmt::Debug, sync::Arc};

use fd_model::{Channel, SampleTime};

use crate::{
    model::Parameter,
    simulate::{Initial, Port, Simulator},
};

/// The input by which a stand-in knows which sample of which log it is at.
pub(crate) const ROW: &str = "replayed_row";

/// A model that is linear around replays, of which rows are steps of the simulator, those of all replays one after
/// the other.
pub(super) trait Linear: Clone + Debug + Send + Sync + 'static {
    /// Steps of all replays.
    fn rows(&self) -> usize;

    /// Starts a run with these parameters and states.
    fn start(&mut self, theta: &[f64], x0: &[f64]);

    /// Writes the outputs of a row.
    fn measure(&mut self, row: usize, u: &[f64], f: &[f64], y: &mut [f64]);

    /// The same, and moves on to the next one.
    fn step(&mut self, row: usize, u: &[f64], f: &[f64], y: &mut [f64]);

    /// The states, or those that the run has begun with.
    fn state(&self) -> &[f64];

    /// Replaces the states, if they can be.
    fn go_on_from(&mut self, x: &[f64]) -> bool;
}

/// What it has in common with the simulator that it stands for.
#[derive(Debug)]
struct Contract {
    ts: SampleTime,
    inputs: Vec<Channel>,
    outputs: Vec<Channel>,
    parameters: Vec<Parameter>,
    initial: Vec<Initial>,
    ports: Vec<Port>,
    /// Of the run that it is linearised along, which is that of all its runs.
    spread: Vec<f64>,
    /// Steps per sample.
    steps: usize,
    /// Whether outputs can be looked at before a step: a force sees those of the step before otherwise, as with
    /// the simulator.
    measures: bool,
}

/// A step of the simulator: the sample that it belongs to, and which of its steps it is.
#[derive(Clone, Copy, Debug)]
struct Step {
    sample: usize,
    number: usize,
}

/// A linear model with the contract of the simulator. Its last input is the row that a step is at, counted in
/// samples; where there is no such row it diverges.
#[derive(Clone, Debug)]
pub(super) struct Replayed<L> {
    contract: Arc<Contract>,
    model: L,
    /// The step before.
    last: Option<Step>,
    no_force: Vec<f64>,
}

impl<L: Linear> Replayed<L> {
    pub(super) fn new(simulator: &dyn Simulator, model: L, steps: usize) -> Self {
        let row = Channel::new(ROW, "1");
        let contract = Contract {
            ts: simulator.ts(),
            inputs: [simulator.inputs(), &[row]].concat(),
            outputs: simulator.outputs().to_vec(),
            parameters: simulator.parameters().to_vec(),
            initial: simulator.initial().to_vec(),
            ports: simulator.ports().to_vec(),
            spread: simulator.spread().to_vec(),
            steps,
            measures: measures(simulator),
        };
        let no_force = vec![0.0; contract.ports.len()];
        Self { contract: Arc::new(contract), model, last: None, no_force }
    }

    /// The step that comes next at a sample.
    fn next(&self, sample: f64) -> Option<Step> {
        let steps = self.contract.steps;
        if !(0.0..(self.model.rows() / steps) as f64).contains(&sample) {
            return None;
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a place")]
        let sample = sample as usize;
        let number = match self.last {
            Some(last) if last.sample == sample => (last.number + 1) % steps,
            _ => 0,
        };
        Some(Step { sample, number })
    }

    fn row(&self, step: Step) -> usize {
        step.sample * self.contract.steps + step.number
    }
}

impl<L: Linear> Simulator for Replayed<L> {
    fn ts(&self) -> SampleTime {
        self.contract.ts
    }

    fn inputs(&self) -> &[Channel] {
        &self.contract.inputs
    }

    fn outputs(&self) -> &[Channel] {
        &self.contract.outputs
    }

    fn parameters(&self) -> &[Parameter] {
        &self.contract.parameters
    }

    fn initial(&self) -> &[Initial] {
        &self.contract.initial
    }

    fn ports(&self) -> &[Port] {
        &self.contract.ports
    }

    fn start(&mut self, theta: &[f64], x0: &[f64], _first: u64) {
        self.model.start(theta, x0);
        self.last = None;
    }

    fn step(&mut self, u: &[f64], _u_next: &[f64], f: &[f64], y: &mut [f64]) {
        let (u, at) = u.split_at(self.contract.inputs.len() - 1);
        let f = if f.is_empty() { &self.no_force } else { f };
        match self.next(at[0]) {
            Some(step) => {
                self.model.step(self.row(step), u, f, y);
                self.last = Some(step);
            }
            None => y.fill(f64::NAN),
        }
    }

    fn measure(&mut self, u: &[f64], y: &mut [f64]) -> bool {
        if !self.contract.measures {
            return false;
        }
        let (u, at) = u.split_at(self.contract.inputs.len() - 1);
        match self.next(at[0]) {
            Some(step) => self.model.measure(self.row(step), u, &self.no_force, y),
            None => y.fill(f64::NAN),
        }
        true
    }

    fn state(&self) -> &[f64] {
        self.model.state()
    }

    fn go_on_from(&mut self, x: &[f64]) -> bool {
        self.model.go_on_from(x)
    }

    fn boxed(&self) -> Box<dyn Simulator> {
        Box::new(self.clone())
    }

    fn spread(&self) -> &[f64] {
        &self.contract.spread
    }
}

/// Whether a simulator can show its outputs without moving on.
fn measures(simulator: &dyn Simulator) -> bool {
    let mut probe = simulator.boxed();
    let theta: Vec<f64> = probe.parameters().iter().map(|p| p.value).collect();
    let x0: Vec<f64> = probe.initial().iter().map(|state| state.value).collect();
    let (u, mut y) = (vec![0.0; probe.inputs().len()], vec![0.0; probe.outputs().len()]);
    probe.start(&theta, &x0, 0);
    let measures = probe.measure(&u, &mut y);
    probe.rest();
    measures
}
