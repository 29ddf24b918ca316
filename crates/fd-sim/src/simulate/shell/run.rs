//! A simulator in its shell, running.

use std::sync::Arc;

use fd_core::StateVisitor;
use fd_model::{Channel, SampleTime};

use super::wiring::{Source, Wiring};
use crate::{
    equation::{Program, Workspace},
    model::{Model, Parameter},
    simulate::{
        EquationSimulator, Initial, Outcome, Port, Run, SimulateError, Simulator, Tape,
        run::{as_tapes, one_by_one},
    },
};

/// Relative error of a ratio of two times that is meant to be whole.
const ROUNDING: f64 = 1e-9;

/// A simulator with equations around it, which change its inputs, forces, outputs and parameters.
///
/// Its parameters are those of the model of the shell, its initial states those of the simulator
/// inside; states that an effect adds start as the effect says.
#[derive(Clone, Debug)]
pub struct ShellSimulator {
    inside: Box<dyn Simulator>,
    ts: SampleTime,
    /// Steps of the simulator inside per sample.
    steps: usize,
    parameters: Arc<[Parameter]>,
    hand_on: Arc<Program>,
    inputs: Arc<[Mean]>,
    forces: Arc<[Mean]>,
    before: Option<Part>,
    needs_outputs: bool,
    after: Option<Part>,
    handed_on: Workspace<f64>,
    /// Parameters, inputs, forces and outputs of the simulator inside.
    theta: Vec<f64>,
    seen: Vec<f64>,
    pushed: Vec<f64>,
    raw: Vec<f64>,
    /// Inputs of the equations: those from outside, then the raw outputs.
    row: Vec<f64>,
    /// Outputs between two samples.
    between: Vec<f64>,
    has_diverged: bool,
    stand_in: Option<Box<dyn Simulator>>,
}

/// Where the mean of a signal over a step comes from, by place.
#[derive(Clone, Copy, Debug)]
enum Mean {
    Zero,
    Input(usize),
    Output(usize),
    Increment(usize),
}

/// Equations before or after the simulator inside.
#[derive(Clone, Debug)]
struct Part {
    equations: EquationSimulator<f64>,
    initial: Vec<f64>,
    /// States at the start of a step.
    at_start: Vec<f64>,
    outputs: Vec<f64>,
}

impl Part {
    fn new(model: &Model, ts: SampleTime) -> Result<Self, SimulateError> {
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
    fn step(&mut self, row: &[f64]) {
        self.at_start.copy_from_slice(self.equations.state());
        self.equations.step(row, row, &[], &mut self.outputs);
    }

    fn mean(&self, mean: Mean, u: &[f64], ts: f64) -> f64 {
        match mean {
            Mean::Zero => 0.0,
            Mean::Input(place) => u[place],
            Mean::Output(place) => self.outputs[place],
            Mean::Increment(place) => (self.equations.state()[place] - self.at_start[place]) / ts,
        }
    }
}

/// Steps of a simulator with samples `own` apart, per sample `ts`.
pub(super) fn steps(own: SampleTime, ts: SampleTime) -> Result<usize, SimulateError> {
    let ratio = ts.seconds() / own.seconds();
    if ratio.round() < 1.0 || ROUNDING * ratio < (ratio - ratio.round()).abs() {
        return Err(SimulateError::Rate { own: own.seconds(), ts: ts.seconds() });
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "whole and at least 1"
    )]
    let steps = ratio.round() as usize;
    Ok(steps)
}

impl ShellSimulator {
    pub(super) fn new(
        inside: Box<dyn Simulator>,
        model: &Model,
        wiring: &Wiring,
        ts: SampleTime,
    ) -> Result<Self, SimulateError> {
        let own = inside.ts();
        let steps = steps(own, ts)?;
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
            ts,
            steps,
            parameters: model.parameters.clone().into(),
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
            between: zeros(ny),
            has_diverged: false,
            stand_in: None,
            inside,
        })
    }

    /// The same simulator with the slopes of another one.
    pub(super) fn with_stand_in(self, stand_in: Option<Box<dyn Simulator>>) -> Self {
        Self { stand_in, ..self }
    }

    /// One step of the simulator inside; `false` when it diverges.
    fn move_on(&mut self, u: &[f64], f: &[f64], y: &mut [f64]) -> bool {
        self.prepare(u, f);
        self.inside.step(&self.seen, &self.seen, &self.pushed, &mut self.raw);
        self.conclude(u, y)
    }

    /// What the simulator inside sees and is pushed with in a step.
    fn prepare(&mut self, u: &[f64], f: &[f64]) {
        let nu = self.seen.len();
        self.row[..nu].copy_from_slice(u);
        match &mut self.before {
            None => {
                self.seen.copy_from_slice(u);
                self.pushed.fill(0.0);
            }
            Some(before) => {
                if self.needs_outputs {
                    // Where this is not possible, the outputs of the step before are still there.
                    self.inside.measure(u, &mut self.raw);
                    self.row[nu..].copy_from_slice(&self.raw);
                }
                before.step(&self.row);
                let ts = self.ts.seconds() / self.steps as f64;
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
    fn conclude(&mut self, u: &[f64], y: &mut [f64]) -> bool {
        let nu = self.seen.len();
        self.row[..nu].copy_from_slice(u);
        if self.raw.iter().any(|value| !value.is_finite()) {
            y.fill(f64::NAN);
            return false;
        }
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

    /// Starts the equations around the simulator inside, and finds its parameters.
    fn start_around(&mut self, theta: &[f64], first: u64) {
        self.handed_on.slow_mut()[..theta.len()].copy_from_slice(theta);
        self.hand_on.prepare(&mut self.handed_on);
        self.hand_on.run(&mut self.handed_on, &mut self.theta);
        for part in self.before.iter_mut().chain(&mut self.after) {
            part.equations.restart(theta, &part.initial, first);
        }
        self.raw.fill(0.0);
        self.row.fill(0.0);
        self.has_diverged = false;
    }

    /// Runs of which the effects do not depend on what the plant does: first all that happens before the
    /// simulator inside, then that in one go, then all that happens after it.
    fn in_one_go(&mut self, first: u64, tapes: &mut [Tape<'_>]) {
        let (nu, nf, ny) = (self.seen.len(), self.pushed.len(), self.raw.len());
        let (steps, begin) = (self.steps, first * self.steps as u64);
        let mut insides = Vec::with_capacity(tapes.len());
        for Tape { run, u, f } in &*tapes {
            let n = run.y.len() / ny * steps;
            let mut inside = Inside {
                theta: Vec::new(),
                u: Vec::with_capacity(n * nu),
                f: Vec::with_capacity(n * nf),
                y: vec![f64::NAN; n * ny],
            };
            self.start_around(run.theta, begin);
            for k in 0..n {
                let k = k / steps;
                self.prepare(&u[k * nu..(k + 1) * nu], &f[k * nf..(k + 1) * nf]);
                inside.u.extend_from_slice(&self.seen);
                inside.f.extend_from_slice(&self.pushed);
            }
            inside.theta.clone_from(&self.theta);
            insides.push(inside);
        }
        let mut inner: Vec<Tape<'_>> = insides
            .iter_mut()
            .zip(&*tapes)
            .map(|(Inside { theta, u, f, y }, tape)| Tape {
                run: Run::new(theta, tape.run.x0, y),
                u,
                f,
            })
            .collect();
        self.inside.replay(begin, &mut inner);
        drop(inner);
        for (Tape { run, u, .. }, inside) in tapes.iter_mut().zip(&insides) {
            self.start_around(run.theta, begin);
            let mut between = vec![0.0; ny];
            for (k, raw) in inside.y.chunks_exact(ny).enumerate() {
                let (sample, is_sample) = (k / steps, k % steps == 0);
                let rows = sample * ny..(sample + 1) * ny;
                let y = if is_sample { &mut run.y[rows] } else { &mut between[..] };
                self.raw.copy_from_slice(raw);
                if !self.has_diverged && !self.conclude(&u[sample * nu..(sample + 1) * nu], y) {
                    self.has_diverged = true;
                }
                if is_sample {
                    if self.has_diverged {
                        run.y[sample * ny..].fill(f64::NAN);
                    }
                    if !run.check(sample, ny) {
                        break;
                    }
                }
            }
            run.finish(ny);
        }
    }
}

/// What the simulator inside is given, and gives, in a whole run.
struct Inside {
    theta: Vec<f64>,
    u: Vec<f64>,
    f: Vec<f64>,
    y: Vec<f64>,
}

impl Simulator for ShellSimulator {
    fn ts(&self) -> SampleTime {
        self.ts
    }

    fn inputs(&self) -> &[Channel] {
        self.inside.inputs()
    }

    fn outputs(&self) -> &[Channel] {
        self.inside.outputs()
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn initial(&self) -> &[Initial] {
        self.inside.initial()
    }

    fn ports(&self) -> &[Port] {
        self.inside.ports()
    }

    fn start(&mut self, theta: &[f64], x0: &[f64], first: u64) {
        let first = first * self.steps as u64;
        self.start_around(theta, first);
        self.inside.start(&self.theta, x0, first);
    }

    fn step(&mut self, u: &[f64], _u_next: &[f64], f: &[f64], y: &mut [f64]) {
        if self.has_diverged {
            y.fill(f64::NAN);
            return;
        }
        let is_fine = self.move_on(u, f, y);
        self.has_diverged = !is_fine;
        let mut between = std::mem::take(&mut self.between);
        for _ in 1..self.steps {
            // A divergence between two samples shows at the second one.
            self.has_diverged = self.has_diverged || !self.move_on(u, f, &mut between);
        }
        self.between = between;
    }

    fn state(&self) -> &[f64] {
        self.inside.state()
    }

    fn visit_memory(&mut self, visitor: &mut dyn StateVisitor<f64>) -> bool {
        if !self.inside.visit_memory(visitor) {
            return false;
        }
        for part in self.before.iter_mut().chain(&mut self.after) {
            part.equations.visit_memory(visitor);
        }
        visitor.reals_with_holes("raw outputs of the shell", &mut self.raw);
        let mut counts = [u64::from(self.has_diverged)];
        visitor.counts("shell has diverged", &mut counts);
        self.has_diverged = counts[0] != 0;
        true
    }

    fn boxed(&self) -> Box<dyn Simulator> {
        Box::new(self.clone())
    }

    fn simulate(&mut self, theta: &[f64], x0: &[f64], u: &[f64], y: &mut [f64]) -> Outcome {
        let mut runs = [Run::new(theta, x0, y)];
        self.simulate_many(0, u, &mut runs);
        runs[0].outcome
    }

    fn simulate_many(&mut self, first: u64, u: &[f64], runs: &mut [Run<'_>]) {
        if self.needs_outputs {
            one_by_one(self, first, u, runs);
            return;
        }
        as_tapes(self, u, runs, |shell, tapes| shell.in_one_go(first, tapes));
    }

    fn rest(&mut self) {
        self.inside.rest();
    }

    fn precision(&self) -> f64 {
        self.inside.precision()
    }

    fn stand_in(&self) -> Option<Box<dyn Simulator>> {
        self.stand_in.clone()
    }
}
