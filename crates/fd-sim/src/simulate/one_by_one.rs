//! What a simulator does that can do no better: one run after the other, step by step.

use super::{
    lock_step::Driven,
    run::{Run, Tape, rows},
    simulator::Simulator,
};

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
        run.make(ny, |k, y| {
            let [now, next] = inputs(k);
            simulator.step(now, next, &[], y);
        });
        simulator.rest();
    }
}

/// Steps through tapes, one after the other.
pub(super) fn step_through<S: Simulator + ?Sized>(
    simulator: &mut S,
    first: u64,
    tapes: &mut [Tape<'_>],
) {
    let (nu, nf) = (simulator.inputs().len(), simulator.ports().len());
    let ny = simulator.outputs().len();
    for Tape { run, u, f } in tapes {
        simulator.start(run.theta, run.x0, first);
        run.make(ny, |k, y| {
            let (u, f) = (&u[k * nu..(k + 1) * nu], &f[k * nf..(k + 1) * nf]);
            simulator.step(u, u, f, y);
        });
        simulator.rest();
    }
}

/// One lane after the other.
pub(crate) fn lane_by_lane<S: Simulator + ?Sized>(
    simulator: &mut S,
    first: u64,
    lanes: &mut [Box<dyn Driven + '_>],
) {
    let (nu, nf, ny) =
        (simulator.inputs().len(), simulator.ports().len(), simulator.outputs().len());
    let (mut u, mut f) = (vec![0.0; nu], vec![0.0; nf]);
    let (mut seen, mut y) = (vec![0.0; ny], vec![0.0; ny]);
    for lane in lanes {
        lane.begin();
        simulator.start(lane.theta(), lane.x0(), first);
        for step in 0..lane.steps() {
            let measures = simulator.measure(lane.input(step), &mut seen);
            lane.drive(step, measures.then_some(&seen[..]), &mut u, &mut f);
            simulator.step(&u, &u, &f, &mut y);
            if !lane.take(step, &y) {
                break;
            }
        }
        simulator.rest();
    }
}
