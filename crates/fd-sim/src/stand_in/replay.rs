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
    /// What the simulator is given instead in a run with effects around it; none without.
    pub driven: Option<&'a Driven>,
}

/// What a simulator in its shell is given in a run, step by step: inputs and forces as effects have changed them.
#[derive(Clone, Debug, PartialEq)]
pub struct Driven {
    /// Number of steps.
    pub steps: usize,
    /// Parameters of the simulator inside.
    pub theta: Vec<f64>,
    /// Inputs, row by row.
    pub u: Vec<f64>,
    /// Forces at its ports, row by row.
    pub f: Vec<f64>,
}

impl Driven {
    /// Without the last input.
    pub(crate) fn without_rows(mut self) -> Self {
        let steps = self.steps;
        let width = self.u.len() / steps.max(1);
        self.u =
            self.u.chunks_exact(width.max(1)).flat_map(|row| row[..width - 1].to_vec()).collect();
        self
    }
}

impl Replay<'_> {
    /// Inputs of a step, of which there are several per sample.
    pub(super) fn input(&self, step: usize, steps: usize, nu: usize) -> &[f64] {
        if let Some(driven) = self.driven {
            return &driven.u[step * nu..(step + 1) * nu];
        }
        let k = step / steps;
        &self.u[k * nu..(k + 1) * nu]
    }

    /// Writes the forces of a step.
    pub(super) fn force(&self, step: usize, f: &mut [f64]) {
        let nf = f.len();
        match self.driven {
            Some(driven) => f.copy_from_slice(&driven.f[step * nf..(step + 1) * nf]),
            None => f.fill(0.0),
        }
    }

    /// Forces of all steps, row by row.
    pub(super) fn forces(&self, steps: usize, nf: usize) -> Vec<f64> {
        self.driven.map_or_else(|| vec![0.0; self.samples * steps * nf], |driven| driven.f.clone())
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
