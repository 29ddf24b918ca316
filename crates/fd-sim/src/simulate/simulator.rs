//! The contract of a simulator.

use std::fmt::Debug;

use fd_core::Scalar;
use fd_model::{Channel, SampleTime};

use crate::model::Parameter;

/// A deterministic model of a plant that can be run from any initial state, with any parameters.
///
/// Per sample, [`step`](Self::step) writes the outputs of this sample and then moves on to the
/// next one. It does not allocate and cannot fail: a simulator that diverges writes NaN from then
/// on, until it is started again.
///
/// Parameters, initial states and ports are optional powers: a pure black box has none of them.
pub trait Simulator: Debug + Send + Sync {
    /// Time between samples.
    fn ts(&self) -> SampleTime;

    /// Inputs of a sample.
    fn inputs(&self) -> &[Channel];

    /// Outputs of a sample.
    fn outputs(&self) -> &[Channel];

    /// Parameters that can be set, with nominal values and tolerances.
    fn parameters(&self) -> &[Parameter];

    /// States of which the initial value can be set.
    fn initial(&self) -> &[Initial];

    /// Places at which a force can be applied.
    fn ports(&self) -> &[Port];

    /// Starts a run at sample number `first` of the log with these parameters and states, in the
    /// order of [`parameters`](Self::parameters) and [`initial`](Self::initial).
    ///
    /// Nothing is left of the run before. Whatever else a simulator remembers (what is on its way
    /// through a delay) starts as if the plant had been at rest until then.
    ///
    /// # Panics
    ///
    /// May panic when the numbers of values are wrong.
    fn start(&mut self, theta: &[f64], x0: &[f64], first: u64);

    /// Writes the outputs `y` of this sample and moves on to the next, with forces `f` in the order of
    /// [`ports`](Self::ports), held until then. `u_next` are the inputs of the next sample, for
    /// simulators that interpolate; others ignore them.
    ///
    /// # Panics
    ///
    /// May panic when the numbers of values are wrong.
    fn step(&mut self, u: &[f64], u_next: &[f64], f: &[f64], y: &mut [f64]);

    /// Writes the outputs of this sample without moving on, and says whether the simulator can do
    /// that. A force that depends on what it moves needs it; without, it sees the outputs of the
    /// sample before.
    ///
    /// # Panics
    ///
    /// May panic when the numbers of values are wrong.
    fn measure(&mut self, _u: &[f64], _y: &mut [f64]) -> bool {
        false
    }

    /// The state now, in the order of [`initial`](Self::initial).
    fn state(&self) -> &[f64];

    /// Replaces the state in the middle of a run, in the order of [`initial`](Self::initial), and keeps
    /// everything else that the simulator remembers. Returns `false`, and does nothing, if that is
    /// not possible.
    fn go_on_from(&mut self, _x: &[f64]) -> bool {
        false
    }

    /// An independent copy, for another thread.
    fn boxed(&self) -> Box<dyn Simulator>;

    /// Runs through `u`, row by row one sample after another, without forces, and writes the
    /// outputs to `y` in the same way. After a divergence the rest of `y` is NaN.
    ///
    /// The number of samples is that of `y`; the last sample is held when `u` is to be
    /// interpolated.
    ///
    /// # Panics
    ///
    /// May panic when the numbers of values are wrong.
    fn simulate(&mut self, theta: &[f64], x0: &[f64], u: &[f64], y: &mut [f64]) -> Outcome {
        let (nu, ny) = (self.inputs().len(), self.outputs().len());
        self.start(theta, x0, 0);
        drive(nu, ny, u, y, |now, next, row| self.step(now, next, &[], row))
    }

    /// Runs several times through the same inputs `u`, row by row one sample after another from
    /// sample number `first` on, without forces. Each run has parameters and an initial state of
    /// its own, and its results are to the bit those of a run alone.
    ///
    /// The number of samples is that of the outputs, the same for all runs. When `u` has a row
    /// more, that is the input after the last sample; else the last one is held.
    ///
    /// A simulator that can do better than one run after the other overrides this.
    ///
    /// # Panics
    ///
    /// May panic when the numbers of values are wrong.
    fn simulate_many(&mut self, first: u64, u: &[f64], runs: &mut [Run<'_>]) {
        one_by_one(self, first, u, runs);
    }
}

/// One of several runs through the same inputs.
#[derive(Debug)]
pub struct Run<'a> {
    /// Parameters, in the order of [`Simulator::parameters`].
    pub theta: &'a [f64],
    /// Initial state, in the order of [`Simulator::initial`].
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
    pub(super) fn check(&mut self, k: usize, ny: usize) -> bool {
        if self.outcome != Outcome::Complete {
            return false;
        }
        if self.y[k * ny..(k + 1) * ny].iter().any(|value| !value.is_finite()) {
            self.outcome = Outcome::Diverged { sample: k };
        }
        self.outcome == Outcome::Complete
    }

    /// Makes the outputs NaN from the divergence on.
    pub(super) fn finish(&mut self, ny: usize) {
        if let Outcome::Diverged { sample } = self.outcome {
            self.y[sample * ny..].fill(f64::NAN);
        }
    }
}

/// The rows of inputs that a run sees, sample by sample, with the row after it.
pub(super) fn rows<'a>(u: &'a [f64], nu: usize) -> impl Fn(usize) -> [&'a [f64]; 2] {
    let last = (u.len() / nu.max(1)).max(1) - 1;
    move |k| [k, (k + 1).min(last)].map(|k| &u[k * nu..(k + 1) * nu])
}

/// One run after the other.
pub(super) fn one_by_one<S: Simulator + ?Sized>(
    simulator: &mut S,
    first: u64,
    u: &[f64],
    runs: &mut [Run<'_>],
) {
    let (nu, ny) = (simulator.inputs().len(), simulator.outputs().len());
    let inputs = rows(u, nu);
    for run in runs {
        simulator.start(run.theta, run.x0, first);
        for k in 0..run.y.len() / ny {
            let [now, next] = inputs(k);
            simulator.step(now, next, &[], &mut run.y[k * ny..(k + 1) * ny]);
            if !run.check(k, ny) {
                break;
            }
        }
        run.finish(ny);
    }
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

impl Clone for Box<dyn Simulator> {
    fn clone(&self) -> Self {
        self.boxed()
    }
}

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

/// A state of which the initial value can be set.
#[derive(Clone, Debug, PartialEq)]
pub struct Initial {
    /// Name and unit.
    pub channel: Channel,
    /// Nominal initial value.
    pub value: f64,
    /// How well it is known, in the unit; `None` when it is exact.
    pub tolerance: Option<f64>,
}

/// A place at which a force can be applied.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Port {
    /// Name of the place and unit of the force.
    pub channel: Channel,
}
