//! Runs through the same inputs, for a simulator that makes runs through inputs of their own.

use super::{
    run::{Outcome, Run, Tape, rows},
    simulator::Simulator,
};

/// Runs through the same inputs, `u` row by row, as tapes without forces; `replay` makes these.
pub(crate) fn as_tapes<S: Simulator>(
    simulator: &mut S,
    u: &[f64],
    runs: &mut [Run<'_>],
    replay: impl FnOnce(&mut S, &mut [Tape<'_>]),
) {
    let (nu, nf) = (simulator.inputs().len(), simulator.ports().len());
    let ny = simulator.outputs().len();
    let inputs = rows(u, nu);
    let samples = runs.iter().map(|run| run.y.len() / ny).max().unwrap_or(0);
    let u: Vec<f64> = (0..samples).flat_map(|k| inputs(k)[0]).copied().collect();
    let f = vec![0.0; samples * nf];
    let mut tapes: Vec<Tape<'_>> = runs
        .iter_mut()
        .map(|run| {
            let n = run.y.len() / ny;
            let again = Run::new(run.theta, run.x0, &mut *run.y);
            Tape { run: again, u: &u[..n * nu], f: &f[..n * nf] }
        })
        .collect();
    replay(simulator, &mut tapes);
    let outcomes: Vec<Outcome> = tapes.into_iter().map(|tape| tape.run.outcome).collect();
    runs.iter_mut().zip(outcomes).for_each(|(run, outcome)| run.outcome = outcome);
}
