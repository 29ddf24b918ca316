//! Several runs of one simulator, step by step beside each other.

use fd_model::SampleTime;

use crate::model::Model;

/// One of several runs that go on together. What drives it may depend on what it shows, which is why it cannot be made
/// in one go.
///
/// The simulator asks: [`begin`](Self::begin), and then for each step [`input`](Self::input),
/// [`drive`](Self::drive) and [`take`](Self::take), in this order.
pub trait Driven: Send {
    /// Begins, or begins again where a simulator has ended in the middle of a run.
    fn begin(&mut self);

    /// Parameters, in the order of [`Simulator::parameters`](super::Simulator::parameters); after [`begin`](Self::begin).
    fn theta(&self) -> &[f64];

    /// Initial state, in the order of [`Simulator::initial`](super::Simulator::initial).
    fn x0(&self) -> &[f64];

    /// How many steps there are to make.
    fn steps(&self) -> usize;

    /// Inputs that come from outside in a step: those that outputs are measured with.
    fn input(&self, step: usize) -> &[f64];

    /// Writes the inputs `u` and the forces `f` of a step. `seen` are the outputs at its start, `None` where the
    /// simulator cannot show them without moving on: those of the step before are then what there is.
    fn drive(&mut self, step: usize, seen: Option<&[f64]>, u: &mut [f64], f: &mut [f64]);

    /// Takes the outputs of a step, and says whether the run goes on.
    fn take(&mut self, step: usize, y: &[f64]) -> bool;

    /// What drives it, where that is the equations of a shell: who has the simulator and these can make the whole run.
    fn equations(&self) -> Option<Around<'_>> {
        None
    }

    /// What drove the last run that was like this one, where that is remembered.
    fn remembered(&self) -> Option<&Settled> {
        None
    }

    /// Remembers what drives this run.
    fn remember(&mut self, _settled: Settled) {}

    /// Takes the outputs of a whole run, made with [`equations`](Self::equations).
    fn take_all(&mut self, _y: &[f64]) {}
}

/// What drives a run of a simulator that makes whole runs only, found by several of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Settled {
    /// Inputs of the simulator, row by row.
    pub u: Vec<f64>,
    /// Forces at its ports, row by row.
    pub f: Vec<f64>,
    /// Largest ratio of the changes that one whole run made and the one before it; 1 where only one was needed.
    pub rate: f64,
}

/// A run of a simulator in equations of a shell.
#[derive(Clone, Copy, Debug)]
pub struct Around<'a> {
    /// The equations.
    pub model: &'a Model,
    /// Time between samples.
    pub ts: SampleTime,
    /// Number of the first sample.
    pub first: u64,
    /// Parameters of the equations.
    pub theta: &'a [f64],
    /// Initial state of the simulator.
    pub x0: &'a [f64],
    /// Inputs of the equations, row by row; the last row is held.
    pub u: &'a [f64],
    /// How many samples there are.
    pub samples: usize,
}
