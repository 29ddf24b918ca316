//! A simulator in its shell, running.

use std::sync::Arc;

use fd_core::StateVisitor;
use fd_model::{Channel, SampleTime};

use super::{
    around::Around,
    lane::{ShellLane, Shelled},
    wiring::Wiring,
};
use crate::{
    model::{Model, Parameter},
    simulate::{
        Driven as DrivenLane, Initial, Outcome, Port, Run, Settled, SimulateError, Simulator, Tape,
        as_tapes, one_by_one::step_through,
    },
    stand_in::Driven,
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
    model: Arc<Model>,
    parameters: Arc<[Parameter]>,
    around: Around,
    /// Outputs between two samples.
    between: Vec<f64>,
    has_diverged: bool,
    stand_in: Option<Box<dyn Simulator>>,
    remembered: Vec<Remembered>,
}

/// What drove the last run through these inputs.
#[derive(Clone, Debug)]
struct Remembered {
    begin: u64,
    u: Vec<f64>,
    settled: Settled,
}

/// Runs through so many different inputs are remembered.
const LOGS: usize = 4;

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
        let around = Around::new(&*inside, wiring, ts.seconds() / steps as f64)?;
        let between = vec![0.0; inside.outputs().len()];
        Ok(Self {
            ts,
            steps,
            parameters: model.parameters.clone().into(),
            model: Arc::new(model.clone()),
            around,
            between,
            has_diverged: false,
            stand_in: None,
            remembered: Vec::new(),
            inside,
        })
    }

    /// The same simulator with the slopes of another one.
    pub(super) fn with_stand_in(self, stand_in: Option<Box<dyn Simulator>>) -> Self {
        Self { stand_in, ..self }
    }

    /// One step of the simulator inside; `false` when it diverges.
    fn move_on(&mut self, u: &[f64], f: &[f64], y: &mut [f64]) -> bool {
        let Self { inside, around, .. } = self;
        around.prepare(u, f, |raw| {
            // Where this is not possible, the outputs of the step before are still there.
            inside.measure(u, raw);
        });
        inside.step(&around.seen, &around.seen, &around.pushed, &mut around.raw);
        around.conclude(u, y)
    }

    /// What the simulator inside is given in a run through the inputs of a log; `None` where that diverges.
    pub(super) fn driven(&mut self, [theta, x0, u]: [&[f64]; 3], first: u64) -> Option<Driven> {
        let nu = self.around.seen.len();
        let mut y = vec![0.0; self.around.raw.len()];
        let (mut inputs, mut forces) = (Vec::new(), Vec::new());
        self.start(theta, x0, first);
        let mut is_fine = true;
        for row in u.chunks_exact(nu) {
            for _ in 0..self.steps {
                is_fine = is_fine && self.move_on(row, &[], &mut y);
                inputs.extend_from_slice(&self.around.seen);
                forces.extend_from_slice(&self.around.pushed);
            }
        }
        self.inside.rest();
        let theta = self.around.theta.clone();
        let steps = u.len() / nu * self.steps;
        is_fine.then_some(Driven { steps, theta, u: inputs, f: forces })
    }

    /// Starts the equations around the simulator inside, and finds its parameters.
    fn start_around(&mut self, theta: &[f64], first: u64) {
        self.around.start(theta, first);
        self.has_diverged = false;
    }

    /// Runs of which the effects depend on what the plant does, step by step beside each other.
    fn in_lock_step(&mut self, first: u64, u: &[f64], runs: &mut [Run<'_>]) {
        let (begin, ny) = (first * self.steps as u64, self.around.raw.len());
        let Self { inside, around, steps, model, ts, remembered, .. } = self;
        let known = remembered.iter().position(|known| known.begin == begin && known.u == u);
        let known = known.map(|known| remembered.remove(known).settled);
        let mut settled = vec![known; runs.len()];
        let shell = Shelled { around, steps: *steps, model, ts: *ts };
        let mut lanes: Vec<Box<dyn DrivenLane + '_>> = Vec::with_capacity(runs.len());
        for (run, settled) in runs.iter_mut().zip(&mut settled) {
            lanes.push(Box::new(ShellLane::new(shell, run, u, begin, settled)));
        }
        inside.lock_step(begin, &mut lanes);
        drop(lanes);
        if let Some(settled) = settled.into_iter().next().flatten() {
            remembered.truncate(LOGS - 1);
            remembered.insert(0, Remembered { begin, u: u.to_vec(), settled });
        }
        for run in runs {
            run.finish(ny);
        }
    }

    /// Runs of which the effects do not depend on what the plant does: first all that happens before the
    /// simulator inside, then that in one go, then all that happens after it.
    fn in_one_go(&mut self, first: u64, tapes: &mut [Tape<'_>]) {
        let Around { seen, pushed, raw, .. } = &self.around;
        let (nu, nf, ny) = (seen.len(), pushed.len(), raw.len());
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
                // Nothing depends on outputs here.
                self.around.prepare(&u[k * nu..(k + 1) * nu], &f[k * nf..(k + 1) * nf], |_| {});
                inside.u.extend_from_slice(&self.around.seen);
                inside.f.extend_from_slice(&self.around.pushed);
            }
            inside.theta.clone_from(&self.around.theta);
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
                self.around.raw.copy_from_slice(raw);
                let u = &u[sample * nu..(sample + 1) * nu];
                if !self.has_diverged && !self.around.conclude(u, y) {
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
        self.inside.start(&self.around.theta, x0, first);
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
        let (parts, [raw, last]) = self.around.memory();
        for part in parts {
            part.equations.visit_memory(visitor);
        }
        visitor.reals_with_holes("raw outputs of the shell", raw);
        visitor.reals_with_holes("outputs that the shell goes on from", last);
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
        if self.around.needs_outputs {
            self.in_lock_step(first, u, runs);
            return;
        }
        as_tapes(self, u, runs, |shell, tapes| shell.in_one_go(first, tapes));
    }

    fn replay(&mut self, first: u64, tapes: &mut [Tape<'_>]) {
        if self.around.needs_outputs {
            step_through(self, first, tapes);
            return;
        }
        self.in_one_go(first, tapes);
    }

    fn rest(&mut self) {
        self.inside.rest();
    }

    fn makes_steps(&self) -> bool {
        self.inside.makes_steps()
    }

    fn precision(&self) -> f64 {
        self.inside.precision()
    }

    fn spread(&self) -> &[f64] {
        self.inside.spread()
    }

    fn repeats(&self) -> bool {
        self.inside.repeats()
    }

    fn workers(&self) -> usize {
        self.inside.workers()
    }

    fn stand_in(&self) -> Option<Box<dyn Simulator>> {
        self.stand_in.clone()
    }
}
