//! Runs of a simulator, and how they are made step by step.

use fd_core::Scalar;

/// How a simulation ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Every output is finite.
    Complete,
    /// Outputs are NaN from this sample on.
    Diverged {
        /// First sample without a finite output, from 0.
        sample: usize,
    },
}

/// A run through inputs and forces of its own.
#[derive(Debug)]
pub struct Tape<'a> {
    /// Parameters, initial state and outputs.
    pub run: Run<'a>,
    /// Inputs, row by row.
    pub u: &'a [f64],
    /// Forces, row by row, in the order of [`Simulator::ports`](super::Simulator::ports).
    pub f: &'a [f64],
}

/// One of several runs through the same inputs.
#[derive(Debug)]
pub struct Run<'a> {
    /// Parameters, in the order of [`Simulator::parameters`](super::Simulator::parameters).
    pub theta: &'a [f64],
    /// Initial state, in the order of [`Simulator::initial`](super::Simulator::initial).
    pub x0: &'a [f64],
    /// Outputs, row by row, to be written; after a divergence the rest is NaN.
    pub y: &'a mut [f64],
    /// How the run ended.
    pub outcome: Outcome,
}

impl<'a> Run<'a> {
    /// A run that is still to be made.
    #[must_use]
    pub fn new(theta: &'a [f64], x0: &'a [f64], y: &'a mut [f64]) -> Self {
        Self { theta, x0, y, outcome: Outcome::Complete }
    }

    /// Looks at the outputs of sample `k`, of which there are `ny`; says whether the run goes on.
    pub(crate) fn check(&mut self, k: usize, ny: usize) -> bool {
        if self.outcome != Outcome::Complete {
            return false;
        }
        if self.y[k * ny..(k + 1) * ny].iter().any(|value| !value.is_finite()) {
            self.outcome = Outcome::Diverged { sample: k };
        }
        self.outcome == Outcome::Complete
    }

    /// Steps through all samples, of `ny` outputs each, until one is not finite; what is left is NaN then.
    pub(super) fn make(&mut self, ny: usize, mut step: impl FnMut(usize, &mut [f64])) {
        for k in 0..self.y.len() / ny {
            step(k, &mut self.y[k * ny..(k + 1) * ny]);
            if !self.check(k, ny) {
                break;
            }
        }
        self.finish(ny);
    }

    /// Makes the outputs NaN from the divergence on.
    pub(crate) fn finish(&mut self, ny: usize) {
        if let Outcome::Diverged { sample } = self.outcome {
            self.y[sample * ny..].fill(f64::NAN);
        }
    }
}

/// The rows of inputs that a run sees, sample by sample, with the row after it.
pub(crate) fn rows<'a>(u: &'a [f64], nu: usize) -> impl Fn(usize) -> [&'a [f64]; 2] {
    let last = (u.len() / nu.max(1)).max(1) - 1;
    move |k| [k, (k + 1).min(last)].map(|k| &u[k * nu..(k + 1) * nu])
}

/// Steps through all samples, until one is not finite.
pub(super) fn drive<T: Scalar>(
    nu: usize,
    ny: usize,
    u: &[f64],
    y: &mut [T],
    mut step: impl FnMut(&[f64], &[f64], &mut [T]),
) -> Outcome {
    let samples = y.len() / ny;
    for k in 0..samples {
        let sample = |k: usize| &u[k * nu..(k + 1) * nu];
        let row = &mut y[k * ny..(k + 1) * ny];
        step(sample(k), sample((k + 1).min(samples - 1)), row);
        if row.iter().any(|value| !value.is_finite()) {
            y[k * ny..].fill(T::from_design(f64::NAN));
            return Outcome::Diverged { sample: k };
        }
    }
    Outcome::Complete
}
