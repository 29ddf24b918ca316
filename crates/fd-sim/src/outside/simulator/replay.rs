//! Whole runs of a simulator outside of this program: one after the other, or side by side.

use std::sync::Arc;

use super::{
    super::{
        loan::{Shared, Work},
        source::{Lane, Start},
        tally::Tally,
    },
    OutsideSimulator, WHOLE,
};
use crate::{
    simulate::{Simulator, Tape},
    workers::on_workers,
};

/// Makes the runs of all tapes; those that can be made in one call together, and those on several instances at once.
pub(super) fn replay(simulator: &mut OutsideSimulator, first: u64, tapes: &mut [Tape<'_>]) {
    let Shared { contract, pool, .. } = &*simulator.shared;
    let lanes = if contract.powers.states { 1 } else { simulator.lanes() };
    // As many groups as there are instances, each no wider than one takes.
    let workers = pool.workers();
    let lanes = lanes.min(tapes.len().div_ceil(workers));
    let groups: Vec<&mut [Tape<'_>]> = tapes.chunks_mut(lanes.max(1)).collect();
    if workers.min(groups.len()) < 2 {
        for group in groups {
            in_one_call(simulator, first, group);
        }
        return;
    }
    let shared = Arc::clone(&simulator.shared);
    on_workers(workers, groups, |group| {
        in_one_call(&mut OutsideSimulator::of(Arc::clone(&shared)), first, group);
    });
}

/// Makes the runs of tapes, in one call if they are several of one length.
fn in_one_call(simulator: &mut OutsideSimulator, first: u64, tapes: &mut [Tape<'_>]) {
    let (nu, nf) = (simulator.inputs().len(), simulator.ports().len());
    let ny = simulator.outputs().len();
    let rows_of = |tape: &Tape<'_>| -> Vec<f64> {
        let samples = tape.run.y.len() / ny;
        let row =
            |k: usize| tape.u[k * nu..(k + 1) * nu].iter().chain(&tape.f[k * nf..(k + 1) * nf]);
        (0..samples).flat_map(row).copied().collect()
    };
    let rows: Vec<Vec<f64>> = tapes.iter().map(rows_of).collect();
    let is_made = side_by_side(simulator, first, &rows, tapes);
    for ((Tape { run, .. }, rows), is_made) in tapes.iter_mut().zip(&rows).zip(is_made) {
        let samples = run.y.len() / ny;
        simulator.start(run.theta, run.x0, first);
        simulator.shared.tapes.note(first, rows);
        if !is_made {
            simulator.roll_out(rows, samples, run.y);
        }
        (0..samples).all(|k| run.check(k, ny));
        run.finish(ny);
    }
    simulator.rest();
}

/// Makes those that are not remembered in one call, if there are several of one length; says which were made. When
/// one of them diverges in a way that ends them all, none was: each is then made by itself.
fn side_by_side(
    simulator: &mut OutsideSimulator,
    first: u64,
    rows: &[Vec<f64>],
    tapes: &mut [Tape<'_>],
) -> Vec<bool> {
    let mut made = vec![false; tapes.len()];
    let size = tapes.first().map_or(0, |tape| tape.run.y.len());
    if tapes.len() < 2 || size == 0 || tapes.iter().any(|tape| tape.run.y.len() != size) {
        return made;
    }
    let samples = size / simulator.outputs().len();
    let mut pasts = Vec::new();
    for (tape, rows) in tapes.iter_mut().zip(rows) {
        simulator.start(tape.run.theta, tape.run.x0, first);
        pasts.push(simulator.origin.with(first).and(rows).with(WHOLE));
    }
    let shared = Arc::clone(&simulator.shared);
    let mut open = Vec::new();
    let mut lanes: Vec<Lane<'_>> = Vec::new();
    for (i, (tape, rows)) in tapes.iter_mut().zip(rows).enumerate() {
        if !shared.recall(pasts[i], [&mut *tape.run.y, &mut []]) {
            let start = Start { theta: tape.run.theta, x0: tape.run.x0, first };
            lanes.push(Lane { start, rows, y: &mut *tape.run.y });
            open.push(i);
        }
    }
    if open.len() < 2 {
        return made;
    }
    let work = simulator.loan.work(&shared, simulator.origin, |instance, reached| {
        *reached = None;
        instance.rollouts(samples, &mut lanes)
    });
    if work == Work::Done {
        let count = open.len() as u64;
        for (counter, by) in [
            (&shared.tally.asked, count),
            (&shared.tally.made, count),
            (&shared.tally.steps, count * samples as u64),
        ] {
            Tally::add(counter, by);
        }
        for i in open {
            made[i] = true;
            shared.keep(pasts[i], [&*tapes[i].run.y, &[]], work);
        }
    }
    made
}

impl OutsideSimulator {
    /// A whole run on a tape of inputs and forces, answered from memory if it was made before. Its end is
    /// where this copy is then. Says whether it was made to the end.
    pub(super) fn roll_out(&mut self, rows: &[f64], samples: usize, y: &mut [f64]) -> bool {
        let past = self.origin.with(self.first).and(rows).with(WHOLE);
        Tally::add(&self.shared.tally.asked, 1);
        if self.shared.recall(past, [y, &mut self.x]) {
            // A run that was refused is remembered as such.
            return y.iter().all(|value| value.is_finite());
        }
        let Self { shared, loan, theta, x0, first, x, .. } = self;
        let start = Start { theta, x0, first: *first };
        let work = loan.work(shared, self.origin, |instance, reached| {
            *reached = None;
            Tally::add(&shared.tally.made, 1);
            Tally::add(&shared.tally.steps, samples as u64);
            instance.rollout(start, rows, samples, y, x)
        });
        if work != Work::Done {
            y.fill(f64::NAN);
        }
        self.shared.keep(past, [y, &self.x], work);
        work == Work::Done
    }
}
