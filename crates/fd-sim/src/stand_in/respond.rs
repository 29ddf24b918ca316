//! From whole runs of a simulator to its responses.

use std::sync::Arc;

use super::{
    difference::{Data, Response, pulse},
    nudge::{nudge, part},
    replay::Replay,
    responses::Known,
};
use crate::simulate::{DifferenceEquation, Outcome, Run, Simulator, Tape};

/// How far inputs and forces are moved, as a part of their size: enough to be seen in seven digits.
const MOVED: f64 = 0.05;
/// How far initial states are moved, as a part of their size.
const STEP: f64 = 1e-3;

/// Most times further that they are moved where equal runs differ.
const ROUGH: f64 = 10.0;

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
    let (mut u, mut f) = (Vec::new(), Vec::new());
    for replay in replays {
        begins.push(u.len() / nu.max(1));
        (0..replay.samples * steps).for_each(|k| u.extend(replay.input(k, steps, nu)));
        f.extend(replay.forces(steps, nf));
    }
    // All at once, the plain run first: a simulator may make several runs in one call, or at the same time.
    let usual = |j: usize| forces.get(j).copied().filter(|f| 0.0 < *f).unwrap_or(1.0);
    let moved = MOVED.max(part(&*simulator));
    let size = |j: usize| moved * if j < nu { peak(&u, nu, j) } else { usual(j - nu) };
    let still = Moved { theta: theta.clone(), x0: x0.clone(), signal: None };
    let mut all = vec![still.clone()];
    all.extend((0..nu + nf).map(|j| Moved { signal: Some((j, size(j))), ..still.clone() }));
    all.extend(nudges.iter().enumerate().map(|(i, step)| {
        let mut moved = still.clone();
        moved.theta[i] += step;
        moved
    }));
    let steps_of_states: Vec<f64> = initial
        .iter()
        .map(|state| {
            let size = state.tolerance.unwrap_or(0.0).max(STEP * state.value.abs());
            let rough = (part(&*simulator) / STEP).min(ROUGH);
            rough * if 0.0 < size { size } else { STEP }
        })
        .collect();
    all.extend(steps_of_states.iter().enumerate().map(|(i, step)| {
        let mut moved = still.clone();
        moved.x0[i] += step;
        moved
    }));
    let mut outputs = whole_runs(&mut *simulator, replays, steps, &all)?.into_iter();
    let y = outputs.next()?;
    let slope = |moved: Vec<f64>, step: f64| -> Vec<f64> {
        moved.iter().zip(&y).map(|(moved, y)| (moved - y) / step).collect()
    };
    let signals = outputs.by_ref().take(nu + nf).enumerate();
    let responses: Vec<Response> =
        signals.map(|(j, moved)| Response { size: size(j), change: slope(moved, 1.0) }).collect();
    let runs = outputs.zip(nudges.iter().chain(&steps_of_states));
    let runs = runs.map(|(moved, step)| slope(moved, *step)).collect();
    let ny = simulator.outputs().len();
    let equations = Data { responses: &responses, begins: &begins, ny }.equations();
    let equations: Arc<[DifferenceEquation]> = equations.into();
    simulator.foretell(&equations);
    Some(Known { theta, x0, u, f, y, begins, runs, equations })
}

/// What is moved in a run.
#[derive(Clone, Debug)]
struct Moved {
    theta: Vec<f64>,
    x0: Vec<f64>,
    /// An input or, after them, a force, and by how much.
    signal: Option<(usize, f64)>,
}

/// Outputs of all replays, one after the other, with each of these moved; `None` where one diverges.
fn whole_runs(
    simulator: &mut dyn Simulator,
    replays: &[Replay<'_>],
    steps: usize,
    all: &[Moved],
) -> Option<Vec<Vec<f64>>> {
    let (nu, nf) = (simulator.inputs().len(), simulator.ports().len());
    let ny = simulator.outputs().len();
    let mut outputs = vec![Vec::new(); all.len()];
    for replay in replays {
        let n = replay.samples * steps;
        let plain: Vec<f64> = (0..n).flat_map(|k| replay.input(k, steps, nu).to_vec()).collect();
        let signals: Vec<[Vec<f64>; 2]> = all
            .iter()
            .map(|moved| {
                let (mut u, mut f) = (plain.clone(), replay.forces(steps, nf));
                if let Some((j, size)) = moved.signal {
                    let (column, width) =
                        if j < nu { (&mut u[j..], nu) } else { (&mut f[j - nu..], nf) };
                    let column = column.iter_mut().step_by(width);
                    column.enumerate().for_each(|(k, w)| *w += pulse(size, k));
                }
                [u, f]
            })
            .collect();
        let mut y = vec![vec![0.0; n * ny]; all.len()];
        let each = all.iter().zip(&signals).zip(&mut y);
        let mut tapes: Vec<Tape<'_>> = each
            .map(|((moved, [u, f]), y)| Tape { run: Run::new(&moved.theta, &moved.x0, y), u, f })
            .collect();
        simulator.replay(replay.begin(steps), &mut tapes);
        if tapes.iter().any(|tape| tape.run.outcome != Outcome::Complete) {
            return None;
        }
        outputs.iter_mut().zip(y).for_each(|(to, y)| to.extend(y));
    }
    Some(outputs)
}

/// Largest value of a column; 1 where it rests at zero.
fn peak(rows: &[f64], width: usize, i: usize) -> f64 {
    let peak = rows.iter().skip(i).step_by(width).fold(0.0_f64, |most, u| most.max(u.abs()));
    if 0.0 < peak { peak } else { 1.0 }
}
