//! Whether a simulator repeats itself, and by how much its runs differ where it does not.
//!
//! A diagnosis takes a difference between two runs for the work of what was changed. Where the simulator has noise in
//! itself (turbulence, contacts resolved in another order, a clock), a part of it is chance. That part is measured
//! by equal runs and made part of the noise of each output.

use std::sync::Arc;

use super::{
    super::{loan::Work, source::Start, spread::Spread, tally::Tally},
    OutsideSimulator, WHOLE,
};
use crate::simulate::Simulator;

/// Runs that are made when the first two differ: the deviation is then known to about two parts in five if a whole run
/// is off by one random number, and much better if each sample has its own.
const RUNS: usize = 4;

impl OutsideSimulator {
    /// Makes the nominal run through so many samples of inputs `u`, row by row, without forces, twice and, where the two
    /// differ, twice more; from then on the simulator and all its copies know of their [`spread`](Simulator::spread).
    /// Returns it, or `None` where the runs are the same to the bit or lost. They count as any others.
    #[must_use]
    pub fn measure_spread(&self, first: u64, u: &[f64], samples: usize) -> Option<&Spread> {
        if self.measured_spread().is_none()
            && let Some(spread) =
                Self::of(Arc::clone(&self.shared)).spread_of_runs(first, u, samples)
        {
            // Another copy may have been faster: then that is it.
            let _ = self.shared.spread.set(spread);
        }
        self.measured_spread()
    }

    fn spread_of_runs(&mut self, first: u64, u: &[f64], samples: usize) -> Option<Spread> {
        let (theta, x0) = self.nominal();
        let (nu, ny) = (self.inputs().len(), self.outputs().len());
        let none = vec![0.0; self.ports().len()];
        let row = |k: usize| u[k * nu..(k + 1) * nu].iter().chain(&none);
        let rows: Vec<f64> = (0..samples).flat_map(row).copied().collect();
        self.start(&theta, &x0, first);
        let mut runs = Vec::new();
        while let Some(y) = self.run_anew(&rows, samples, ny) {
            runs.push(y);
            if runs.len() == RUNS || runs.len() == 2 && Spread::among(&runs, ny).is_none() {
                break;
            }
        }
        self.rest();
        Spread::among(&runs, ny)
    }

    /// The spread, where it was measured and is none.
    pub(super) fn measured_spread(&self) -> Option<&Spread> {
        self.shared.spread.get()
    }

    fn nominal(&self) -> (Vec<f64>, Vec<f64>) {
        let theta = self.parameters().iter().map(|p| p.value).collect();
        (theta, self.initial().iter().map(|state| state.value).collect())
    }

    /// Outputs of the run that was started, made whether it is remembered or not; the first one is remembered.
    fn run_anew(&mut self, rows: &[f64], samples: usize, ny: usize) -> Option<Vec<f64>> {
        let past = self.origin.with(self.first).and(rows).with(WHOLE);
        let Self { shared, loan, theta, x0, first, x, .. } = self;
        let start = Start { theta, x0, first: *first };
        let mut y = vec![0.0; samples * ny];
        Tally::add(&shared.tally.asked, 1);
        if shared.contract.powers.rollout {
            // Steps through these inputs are foreseen from here on.
            shared.tapes.note(*first, rows);
        }
        let work = loan.work(shared, self.origin, |instance, reached| {
            *reached = None;
            Tally::add(&shared.tally.made, 1);
            Tally::add(&shared.tally.steps, samples as u64);
            instance.rollout(start, rows, samples, &mut y, x)
        });
        if !shared.recall(past, [&mut vec![0.0; y.len()], &mut x.clone()]) {
            shared.keep(past, [&y, x], work);
        }
        (work == Work::Done).then_some(y)
    }
}
