//! The replays along which a simulator is linearised.

use crate::simulate::Simulator;

/// A run that is replayed: the inputs of a log, in the order and the units of the simulator, and where it begins.
#[derive(Clone, Copy, Debug)]
pub struct Replay<'a> {
    /// Inputs, row by row.
    pub u: &'a [f64],
    /// Number of samples.
    pub samples: usize,
    /// Number of the first sample since the clock of the model was started.
    pub first: u64,
    /// Initial states; none for the nominal ones.
    pub x0: Option<&'a [f64]>,
}

impl Replay<'_> {
    /// Inputs of a step, of which there are several per sample.
    pub(super) fn input(&self, step: usize, steps: usize, nu: usize) -> &[f64] {
        let k = step / steps;
        &self.u[k * nu..(k + 1) * nu]
    }

    /// Initial states of a simulator.
    pub(super) fn start(&self, simulator: &dyn Simulator) -> Vec<f64> {
        let nominal = || simulator.initial().iter().map(|state| state.value).collect();
        self.x0.map_or_else(nominal, <[f64]>::to_vec)
    }

    /// Number of the first step.
    pub(super) fn begin(&self, steps: usize) -> u64 {
        self.first * steps as u64
    }
}
