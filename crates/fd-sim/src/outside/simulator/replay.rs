//! Whole runs of a simulator outside of this program: one after the other, or side by side.

use super::{
    super::{
        loan::Work,
        source::{Lane, Start},
        tally::Tally,
    },
    OutsideSimulator, WHOLE,
};
use crate::simulate::{Simulator, Tape};

/// Makes the runs of all tapes; those that can be made in one call first.
pub(super) fn replay(simulator: &mut OutsideSimulator, first: u64, tapes: &mut [Tape<'_>]) {
    let (nu, nf) = (simulator.inputs().len(), simulator.ports().len());
    let ny = simulator.outputs().len();
    let rows_of = |tape: &Tape<'_>| -> Vec<f64> {
        let samples = tape.run.y.len() / ny;
        let row =
            |k: usize| tape.u[k * nu..(k + 1) * nu].iter().chain(&tape.f[k * nf..(k + 1) * nf]);
        (0..samples).flat_map(row).copied().collect()
    };
    let mut lanes = simulator.shared.source.lanes().max(1);
    if simulator.shared.contract.powers.states {
        lanes = 1;
    }
    for tapes in tapes.chunks_mut(lanes) {
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
    let shared = std::sync::Arc::clone(&simulator.shared);
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
