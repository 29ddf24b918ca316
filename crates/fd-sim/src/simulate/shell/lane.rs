//! A run in a shell, beside others.

use fd_model::SampleTime;

use super::around::Around;
use crate::{
    model::Model,
    simulate::{self, Driven, Outcome, Run, Settled, run::rows},
};

/// What all lanes have in common.
#[derive(Clone, Copy)]
pub(super) struct Shelled<'r> {
    pub around: &'r Around,
    pub steps: usize,
    pub model: &'r Model,
    pub ts: SampleTime,
}

/// The equations around one lane of the simulator inside.
pub(super) struct ShellLane<'r, 'a> {
    around: Around,
    run: &'r mut Run<'a>,
    /// Inputs, row by row; the last row is held.
    u: &'r [f64],
    /// Steps of the simulator inside per sample.
    steps: usize,
    /// The first of them.
    begin: u64,
    /// Equations of the shell, and the time between samples.
    model: &'r Model,
    ts: SampleTime,
    /// Outputs between two samples.
    between: Vec<f64>,
    /// What drove the last run like this one, and then this one.
    settled: &'r mut Option<Settled>,
}

impl<'r, 'a> ShellLane<'r, 'a> {
    pub(super) fn new(
        shell: Shelled<'r>,
        run: &'r mut Run<'a>,
        u: &'r [f64],
        begin: u64,
        settled: &'r mut Option<Settled>,
    ) -> Self {
        let Shelled { around, steps, model, ts } = shell;
        let between = vec![0.0; around.raw.len()];
        Self { around: around.clone(), run, u, steps, begin, model, ts, between, settled }
    }

    fn samples(&self) -> usize {
        self.run.y.len() / self.between.len().max(1)
    }
}

impl Driven for ShellLane<'_, '_> {
    fn begin(&mut self) {
        self.around.start(self.run.theta, self.begin);
        self.run.outcome = Outcome::Complete;
    }

    fn theta(&self) -> &[f64] {
        &self.around.theta
    }

    fn x0(&self) -> &[f64] {
        self.run.x0
    }

    fn steps(&self) -> usize {
        self.samples() * self.steps
    }

    fn input(&self, step: usize) -> &[f64] {
        rows(self.u, self.around.seen.len())(step / self.steps)[0]
    }

    fn drive(&mut self, step: usize, seen: Option<&[f64]>, u: &mut [f64], f: &mut [f64]) {
        let now = rows(self.u, self.around.seen.len())(step / self.steps)[0];
        self.around.prepare(now, &[], |raw| {
            // Without, the outputs of the step before are still there.
            if let Some(seen) = seen {
                raw.copy_from_slice(seen);
            }
        });
        u.copy_from_slice(&self.around.seen);
        f.copy_from_slice(&self.around.pushed);
    }

    fn take(&mut self, step: usize, y: &[f64]) -> bool {
        let (sample, ny) = (step / self.steps, self.between.len());
        let now = rows(self.u, self.around.seen.len())(sample)[0];
        self.around.raw.copy_from_slice(y);
        if step.is_multiple_of(self.steps) {
            let row = &mut self.run.y[sample * ny..(sample + 1) * ny];
            self.around.conclude(now, row);
            return self.run.check(sample, ny);
        }
        let is_fine = self.around.conclude(now, &mut self.between);
        // A divergence between two samples shows at the second one.
        if !is_fine && sample + 1 < self.samples() {
            self.run.outcome = Outcome::Diverged { sample: sample + 1 };
        }
        is_fine
    }

    fn equations(&self) -> Option<simulate::Around<'_>> {
        Some(simulate::Around {
            model: self.model,
            ts: self.ts,
            first: self.begin / self.steps as u64,
            theta: self.run.theta,
            x0: self.run.x0,
            u: self.u,
            samples: self.samples(),
        })
    }

    fn remembered(&self) -> Option<&Settled> {
        self.settled.as_ref()
    }

    fn remember(&mut self, settled: Settled) {
        *self.settled = Some(settled);
    }

    fn take_all(&mut self, y: &[f64]) {
        self.run.outcome = Outcome::Complete;
        self.run.y.copy_from_slice(y);
        let ny = self.between.len();
        (0..self.samples()).all(|sample| self.run.check(sample, ny));
    }
}
