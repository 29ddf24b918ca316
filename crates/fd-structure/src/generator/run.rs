//! A residual generator, running along a log.

use fd_sim::equation::Workspace;
use thiserror::Error;

use super::design::{FIRST_SIGNAL, Residual};

/// The residual of a sample could not be computed. The generator goes on with the next sample from the state that it had.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum StepError {
    /// The wrong number of signals.
    #[error("expected {expected} signals, found {found}")]
    Signals {
        /// Number of known signals.
        expected: usize,
        /// Number of values.
        found: usize,
    },
    /// A block has no solution near the last one.
    #[error(
        "{unknowns} could not be solved for: no finite solution of {equations} equation(s) near the last one"
    )]
    Unsolved {
        /// Names of the unknowns.
        unknowns: String,
        /// Number of equations.
        equations: usize,
    },
    /// The residual, or a state, is not finite.
    #[error("the residual is not finite: a signal is missing, or the model has run away")]
    NotFinite,
}

/// A [`Residual`] with its memory.
#[derive(Clone, Debug)]
pub struct RunningResidual<'a> {
    design: &'a Residual,
    workspaces: Vec<Workspace<f64>>,
    residual: Workspace<f64>,
    /// Time, `first`, unknowns, known signals.
    fast: Vec<f64>,
    /// The signals of the sample before.
    last: Option<Vec<f64>>,
    samples: u64,
}

impl Residual {
    /// At the beginning of a run.
    #[must_use]
    pub fn start(&self) -> RunningResidual<'_> {
        RunningResidual::new(self)
    }
}

impl<'a> RunningResidual<'a> {
    pub(super) fn new(design: &'a Residual) -> Self {
        let prepared = |program: &fd_sim::equation::Program| {
            let mut workspace = program.workspace::<f64>();
            let slow = workspace.slow_mut();
            let dt = design.sample_time / design.substeps as f64;
            for (slot, value) in slow.iter_mut().zip(design.parameters.iter().chain([&dt])) {
                *slot = *value;
            }
            program.prepare(&mut workspace);
            workspace
        };
        let mut fast = vec![0.0; design.scope.fast.len()];
        fast[1] = 1.0;
        Self {
            workspaces: design.blocks.iter().map(|block| prepared(&block.program)).collect(),
            residual: prepared(&design.difference),
            fast,
            last: None,
            samples: 0,
            design,
        }
    }

    /// The residual of the next sample, from the values of the known signals in it. Its unit is that of the residual equation.
    ///
    /// # Errors
    ///
    /// Returns an error when the number of signals is wrong, an equation has no solution, or a signal is not finite.
    pub fn step(&mut self, knowns: &[f64]) -> Result<f64, StepError> {
        let expected = self.design.knowns.len();
        if knowns.len() != expected {
            return Err(StepError::Signals { expected, found: knowns.len() });
        }
        if !knowns.iter().all(|value| value.is_finite()) {
            return Err(StepError::NotFinite);
        }
        let before = self.fast.clone();
        let result = match self.last.take() {
            None => {
                self.begin(knowns);
                Ok(())
            }
            Some(last) => self.advance(&last, knowns),
        };
        let result = result.and_then(|()| self.evaluate(knowns));
        if result.is_err() {
            self.fast = before;
        }
        self.last = Some(knowns.to_vec());
        self.samples += 1;
        result
    }

    fn begin(&mut self, knowns: &[f64]) {
        let design = self.design;
        let mut workspace = design.guess.workspace::<f64>();
        let dt = design.sample_time / design.substeps as f64;
        for (slot, value) in
            workspace.slow_mut().iter_mut().zip(design.parameters.iter().chain([&dt]))
        {
            *slot = *value;
        }
        design.guess.prepare(&mut workspace);
        let fast = workspace.fast_mut();
        fast[1] = 1.0;
        fast[FIRST_SIGNAL..].copy_from_slice(knowns);
        let unknowns = FIRST_SIGNAL..self.fast.len() - knowns.len();
        design.guess.run(&mut workspace, &mut self.fast[unknowns.clone()]);
        for value in &mut self.fast[unknowns] {
            // A guess only, away from the poles and kinks at zero.
            if !value.is_finite() {
                *value = 1.0;
            }
        }
        for state in &design.states {
            self.fast[state.state] = state.initial;
        }
    }

    fn evaluate(&mut self, knowns: &[f64]) -> Result<f64, StepError> {
        self.set(self.samples as f64 * self.design.sample_time, knowns);
        self.solve()?;
        let mut value = [f64::NAN];
        self.residual.fast_mut().copy_from_slice(&self.fast);
        self.design.difference.run(&mut self.residual, &mut value);
        if value[0].is_finite() { Ok(value[0]) } else { Err(StepError::NotFinite) }
    }

    fn set(&mut self, time: f64, knowns: &[f64]) {
        self.fast[0] = time;
        let first = self.fast.len() - knowns.len();
        self.fast[first..].copy_from_slice(knowns);
    }

    /// Everything but the states, from the states and the known signals.
    fn solve(&mut self) -> Result<(), StepError> {
        for (index, block) in self.design.blocks.iter().enumerate() {
            if !block.solve(&mut self.workspaces[index], &mut self.fast) {
                let solve = &self.design.solves[index];
                let (unknowns, equations) = (solve.unknowns.join(", "), solve.equations.len());
                return Err(StepError::Unsolved { unknowns, equations });
            }
        }
        Ok(())
    }

    /// From one sample to the next: Runge-Kutta of order 4; updates take what held at the start of a step.
    fn advance(&mut self, last: &[f64], next: &[f64]) -> Result<(), StepError> {
        let design = self.design;
        if design.states.is_empty() {
            self.fast[1] = 0.0;
            return Ok(());
        }
        let h = design.sample_time / design.substeps as f64;
        let start = (self.samples - 1) as f64 * design.sample_time;
        let at = |share: f64| -> Vec<f64> {
            let ways = last.iter().zip(next).zip(&design.is_linear);
            ways.map(|((a, b), &linear)| if linear { a + share * (b - a) } else { *a }).collect()
        };
        for substep in 0..design.substeps {
            let share = |part: f64| (substep as f64 + part) / design.substeps as f64;
            let time = |part: f64| start + (substep as f64 + part) * h;
            let old: Vec<f64> = design.states.iter().map(|state| self.fast[state.state]).collect();
            let mut mean = vec![0.0; old.len()];
            let mut slopes = vec![0.0; old.len()];
            let mut updates = Vec::new();
            for (part, weight) in [(0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)] {
                for (index, state) in design.states.iter().enumerate() {
                    let moved = if state.is_update { 0.0 } else { part * h * slopes[index] };
                    self.fast[state.state] = old[index] + moved;
                }
                self.set(time(part), &at(share(part)));
                self.solve()?;
                if updates.is_empty() {
                    updates = design.states.iter().map(|state| self.fast[state.rate]).collect();
                }
                for (index, state) in design.states.iter().enumerate() {
                    slopes[index] = self.fast[state.rate];
                    mean[index] += weight / 6.0 * slopes[index];
                }
            }
            for (index, state) in design.states.iter().enumerate() {
                let moved =
                    if state.is_update { updates[index] } else { old[index] + h * mean[index] };
                if !moved.is_finite() {
                    return Err(StepError::NotFinite);
                }
                self.fast[state.state] = moved;
            }
            self.fast[1] = 0.0;
        }
        Ok(())
    }
}
