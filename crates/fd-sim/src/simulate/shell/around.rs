//! What a shell does before and after a step of the simulator inside.

use std::sync::Arc;

use fd_model::{Channel, Circle};

use super::{
    part::{Mean, Part},
    wiring::{Source, Wiring},
};
use crate::{
    equation::{Program, Workspace},
    model::Model,
    simulate::{SimulateError, Simulator},
};

/// The equations around the simulator inside, in the course of a run.
#[derive(Clone, Debug)]
pub(super) struct Around {
    /// Of the simulator inside.
    step_seconds: f64,
    hand_on: Arc<Program>,
    inputs: Arc<[Mean]>,
    forces: Arc<[Mean]>,
    before: Option<Part>,
    /// Whether what happens before a step depends on outputs.
    pub needs_outputs: bool,
    after: Option<Part>,
    handed_on: Workspace<f64>,
    /// Parameters, inputs, forces and outputs of the simulator inside.
    pub theta: Vec<f64>,
    pub seen: Vec<f64>,
    pub pushed: Vec<f64>,
    pub raw: Vec<f64>,
    /// Inputs of the equations: those from outside, then the raw outputs.
    row: Vec<f64>,
    /// Where the raw outputs live, and where they were last: an angle goes on, though the simulator begins it anew.
    circles: Arc<[Circle]>,
    last: Vec<f64>,
}

impl Around {
    /// The equations of a shell around a simulator with steps of so many seconds.
    pub(super) fn new(
        inside: &dyn Simulator,
        wiring: &Wiring,
        step_seconds: f64,
    ) -> Result<Self, SimulateError> {
        let own = inside.ts();
        let part = |model: &Option<Model>| model.as_ref().map(|m| Part::new(m, own)).transpose();
        let before = part(&wiring.before)?;
        let place = |source: &Source| match source {
            Source::Zero => Ok(Mean::Zero),
            Source::Input(place) => Ok(Mean::Input(*place)),
            Source::Output(place) => Ok(Mean::Output(*place)),
            Source::Increment(name) => {
                let states = before.iter().flat_map(|part| part.equations.initial());
                let place = states.into_iter().position(|state| state.channel.name == *name);
                let missing =
                    || SimulateError::NotThisShell { what: "integral", name: name.clone() };
                place.map(Mean::Increment).ok_or_else(missing)
            }
        };
        let inputs = wiring.inputs.iter().map(place).collect::<Result<_, _>>()?;
        let forces = wiring.forces.iter().map(place).collect::<Result<_, _>>()?;
        let zeros = |n: usize| vec![0.0; n];
        let (nu, ny) = (inside.inputs().len(), inside.outputs().len());
        Ok(Self {
            step_seconds,
            handed_on: wiring.parameters.workspace(),
            hand_on: Arc::new(wiring.parameters.clone()),
            inputs,
            forces,
            before,
            needs_outputs: wiring.needs_outputs,
            after: part(&wiring.after)?,
            theta: zeros(inside.parameters().len()),
            seen: zeros(nu),
            pushed: zeros(inside.ports().len()),
            raw: zeros(ny),
            row: zeros(nu + ny),
            circles: inside.outputs().iter().map(Channel::circle).collect(),
            last: vec![f64::NAN; ny],
        })
    }

    /// Starts the equations, and finds the parameters of the simulator inside.
    pub(super) fn start(&mut self, theta: &[f64], first: u64) {
        self.handed_on.slow_mut()[..theta.len()].copy_from_slice(theta);
        self.hand_on.prepare(&mut self.handed_on);
        self.hand_on.run(&mut self.handed_on, &mut self.theta);
        for part in self.before.iter_mut().chain(&mut self.after) {
            part.equations.restart(theta, &part.initial, first);
        }
        self.raw.fill(0.0);
        self.row.fill(0.0);
        self.last.fill(f64::NAN);
    }

    /// Raw outputs without the jumps of angles.
    fn go_on(&mut self) {
        let lasts = self.last.iter_mut().zip(&*self.circles);
        for (raw, (last, circle)) in self.raw.iter_mut().zip(lasts) {
            *raw = circle.go_on(*raw, last);
        }
    }

    /// What the simulator inside sees and is pushed with in a step; `measure` writes its outputs, if anything depends
    /// on them and it can.
    pub(super) fn prepare(&mut self, u: &[f64], f: &[f64], measure: impl FnOnce(&mut [f64])) {
        let nu = self.seen.len();
        self.row[..nu].copy_from_slice(u);
        if self.before.is_some() && self.needs_outputs {
            measure(&mut self.raw);
            self.go_on();
            self.row[nu..].copy_from_slice(&self.raw);
        }
        match &mut self.before {
            None => {
                self.seen.copy_from_slice(u);
                self.pushed.fill(0.0);
            }
            Some(before) => {
                before.step(&self.row);
                let ts = self.step_seconds;
                for (seen, mean) in self.seen.iter_mut().zip(&*self.inputs) {
                    *seen = before.mean(*mean, u, ts);
                }
                for (pushed, mean) in self.pushed.iter_mut().zip(&*self.forces) {
                    *pushed = before.mean(*mean, u, ts);
                }
            }
        }
        self.pushed.iter_mut().zip(f).for_each(|(pushed, f)| *pushed += f);
    }

    /// What the sensors make of the raw outputs; `false` when these are not finite.
    pub(super) fn conclude(&mut self, u: &[f64], y: &mut [f64]) -> bool {
        let nu = self.seen.len();
        self.row[..nu].copy_from_slice(u);
        if self.raw.iter().any(|value| !value.is_finite()) {
            y.fill(f64::NAN);
            return false;
        }
        self.go_on();
        match &mut self.after {
            None => y.copy_from_slice(&self.raw),
            Some(after) => {
                self.row[nu..].copy_from_slice(&self.raw);
                after.step(&self.row);
                y.copy_from_slice(&after.outputs);
            }
        }
        true
    }

    /// The parts before and after, the raw outputs, and where these go on from: all that a run remembers.
    pub(super) fn memory(&mut self) -> (impl Iterator<Item = &mut Part>, [&mut [f64]; 2]) {
        (self.before.iter_mut().chain(&mut self.after), [&mut self.raw, &mut self.last])
    }
}
