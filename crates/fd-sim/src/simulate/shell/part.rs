//! The equations of a shell before and after the simulator inside.

use fd_model::SampleTime;

use crate::{
    model::Model,
    simulate::{EquationSimulator, SimulateError, Simulator},
};

/// Where the mean of a signal over a step comes from, by place.
#[derive(Clone, Copy, Debug)]
pub(super) enum Mean {
    Zero,
    Input(usize),
    Output(usize),
    Increment(usize),
}

/// Equations before or after the simulator inside.
#[derive(Clone, Debug)]
pub(super) struct Part {
    pub equations: EquationSimulator<f64>,
    pub initial: Vec<f64>,
    /// States at the start of a step.
    at_start: Vec<f64>,
    pub outputs: Vec<f64>,
}

impl Part {
    pub(super) fn new(model: &Model, ts: SampleTime) -> Result<Self, SimulateError> {
        let mut draft = model.clone().into_draft();
        // What is inside sees one mean per step of its own, whatever step an effect would like.
        (draft.sample_time, draft.step) = (ts.seconds(), Some(ts.seconds()));
        let model = Model::try_from(draft)?;
        let initial = model.initial();
        Ok(Self {
            equations: EquationSimulator::at(&model, ts)?,
            at_start: initial.clone(),
            initial,
            outputs: vec![0.0; model.outputs.len()],
        })
    }

    /// Moves on by one step.
    pub(super) fn step(&mut self, row: &[f64]) {
        self.at_start.copy_from_slice(self.equations.state());
        self.equations.step(row, row, &[], &mut self.outputs);
    }

    pub(super) fn mean(&self, mean: Mean, u: &[f64], ts: f64) -> f64 {
        match mean {
            Mean::Zero => 0.0,
            Mean::Input(place) => u[place],
            Mean::Output(place) => self.outputs[place],
            Mean::Increment(place) => (self.equations.state()[place] - self.at_start[place]) / ts,
        }
    }
}
