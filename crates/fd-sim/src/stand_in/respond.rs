//! From whole runs of a simulator to its responses.

use super::{
    difference::{Data, Response},
    nudge::nudge,
    replay::Replay,
    responses::Known,
};
use crate::simulate::{Outcome, Run, Simulator, Tape};

/// How far inputs and forces are moved, as a part of their size: enough to be seen in seven digits.
const MOVED: f64 = 0.05;
/// Steps into one direction, one after another: fast and slow plants are moved.
const HOLDS: [usize; 6] = [3, 29, 7, 83, 13, 47];
/// How far initial states are moved, as a part of their size.
const STEP: f64 = 1e-3;

/// Runs through the replays, once as they are, and once more for everything that can be moved. `None` when a run
/// diverges.
pub(super) fn respond(
    simulator: &dyn Simulator,
    replays: &[Replay<'_>],
    steps: usize,
    forces: &[f64],
    theta: &[f64],
) -> Option<Known> {
    let mut simulator = simulator.boxed();
    let (nu, nf) = (simulator.inputs().len(), simulator.ports().len());
    let initial = simulator.initial().to_vec();
    let nudges: Vec<f64> =
        theta.iter().enumerate().map(|(i, p)| nudge(&*simulator, i, *p)).collect();
    let theta = theta.to_vec();
    let x0: Vec<f64> = initial.iter().map(|state| state.value).collect();
    let mut begins = Vec::new();
    let mut u = Vec::new();
    for replay in replays {
        begins.push(u.len() / nu.max(1));
        (0..replay.samples * steps).for_each(|k| u.extend(replay.input(k, steps, nu)));
    }
    let mut outputs = |theta: &[f64], x0: &[f64], moved: Option<(usize, f64)>| {
        whole_runs(&mut *simulator, replays, steps, theta, x0, moved)
    };
    let y = outputs(&theta, &x0, None)?;
    let slope = |moved: &[f64], step: f64| -> Vec<f64> {
        moved.iter().zip(&y).map(|(moved, y)| (moved - y) / step).collect()
    };
    let mut responses = Vec::new();
    for j in 0..nu + nf {
        let usual = |j: usize| forces.get(j).copied().filter(|f| 0.0 < *f).unwrap_or(1.0);
        let size = MOVED * if j < nu { peak(&u, nu, j) } else { usual(j - nu) };
        let change = slope(&outputs(&theta, &x0, Some((j, size)))?, 1.0);
        responses.push(Response { size, change });
    }
    let mut runs = Vec::new();
    for (i, step) in nudges.into_iter().enumerate() {
        let mut moved = theta.clone();
        moved[i] += step;
        runs.push(slope(&outputs(&moved, &x0, None)?, step));
    }
    for (i, state) in initial.iter().enumerate() {
        let size = state.tolerance.unwrap_or(0.0).max(STEP * state.value.abs());
        let step = if 0.0 < size { size } else { STEP };
        let mut moved = x0.clone();
        moved[i] += step;
        runs.push(slope(&outputs(&theta, &moved, None)?, step));
    }
    let ny = simulator.outputs().len();
    let equations = Data { responses: &responses, begins: &begins, ny }.equations();
    Some(Known { theta, x0, u, y, begins, runs, equations })
}

/// Outputs of all replays, one after the other, with an input or a force moved; `None` where one diverges.
fn whole_runs(
    simulator: &mut dyn Simulator,
    replays: &[Replay<'_>],
    steps: usize,
    theta: &[f64],
    x0: &[f64],
    moved: Option<(usize, f64)>,
) -> Option<Vec<f64>> {
    let (nu, nf) = (simulator.inputs().len(), simulator.ports().len());
    let ny = simulator.outputs().len();
    let mut all = Vec::new();
    for replay in replays {
        let n = replay.samples * steps;
        let mut u: Vec<f64> = (0..n).flat_map(|k| replay.input(k, steps, nu).to_vec()).collect();
        let mut f = vec![0.0; n * nf];
        if let Some((j, size)) = moved {
            let (column, width) = if j < nu { (&mut u[j..], nu) } else { (&mut f[j - nu..], nf) };
            column.iter_mut().step_by(width).enumerate().for_each(|(k, w)| *w += pulse(size, k));
        }
        let mut y = vec![0.0; n * ny];
        let run = Run::new(theta, x0, &mut y);
        let mut tapes = [Tape { run, u: &u, f: &f }];
        simulator.replay(replay.begin(steps), &mut tapes);
        if tapes[0].run.outcome != Outcome::Complete {
            return None;
        }
        all.extend(y);
    }
    Some(all)
}

/// What an input or a force is moved by in a step: up and down, for as many steps as `HOLDS` say.
pub(super) fn pulse(size: f64, k: usize) -> f64 {
    let mut left = k % (2 * HOLDS.iter().sum::<usize>());
    for (i, hold) in HOLDS.iter().cycle().enumerate() {
        if left < *hold {
            return if i % 2 == 0 { size } else { -size };
        }
        left -= hold;
    }
    0.0
}

/// Largest value of a column; 1 where it rests at zero.
fn peak(rows: &[f64], width: usize, i: usize) -> f64 {
    let peak = rows.iter().skip(i).step_by(width).fold(0.0_f64, |most, u| most.max(u.abs()));
    if 0.0 < peak { peak } else { 1.0 }
}
