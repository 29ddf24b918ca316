//! From runs of a simulator to its slopes along replays.

use super::{
    nudge::{STEP, nudge},
    replay::Replay,
    slopes::Slopes,
};
use crate::{simulate::Simulator, workers::on_workers};

/// Runs through the replays, once as they are, and once more for everything that can be moved, in each step from
/// the state that the replay has there; states, inputs and forces by a `part` of what they usually do. `None` when that
/// is not possible, or a run diverges.
pub(super) fn linearise(
    simulator: &dyn Simulator,
    replays: &[Replay<'_>],
    steps: usize,
    forces: &[f64],
    theta: &[f64],
    part: f64,
) -> Option<Slopes> {
    if !simulator.makes_steps() {
        return None;
    }
    let mut simulator = simulator.boxed();
    let nu = simulator.inputs().len();
    let nx = simulator.initial().len();
    let nf = simulator.ports().len();
    let theta = theta.to_vec();
    let ny = simulator.outputs().len();
    let widths = [nx, nu, nf, theta.len()];
    let mut found = Slopes {
        widths,
        ny,
        theta: theta.clone(),
        u: vec![],
        f: vec![],
        x: vec![],
        result: vec![],
        columns: vec![],
    };
    let still = Moved { x: None, u: None, f: None, theta };
    (found.x, found.result) = walk(&mut *simulator, replays, steps, &still, None)?;
    if !shows_its_states(&found.x, nx) {
        return None;
    }
    for replay in replays {
        (0..replay.samples * steps).for_each(|k| found.u.extend(replay.input(k, steps, nu)));
        found.f.extend(replay.forces(steps, nf));
    }
    let columns: usize = widths.iter().sum();
    found.columns = vec![0.0; found.result.len() * columns];
    let (rows, results) = (found.rows(), found.results());
    let all = all_moved(&*simulator, &found, forces, part);
    let mut walked: Vec<Option<Walked>> = all.iter().map(|_| None).collect();
    let work: Vec<_> = all.iter().zip(&mut walked).collect();
    on_workers(simulator.workers(), work, |((moved, _), walked)| {
        *walked = walk(&mut *simulator.boxed(), replays, steps, moved, Some(&found.x));
    });
    for (column, ((_, step), walked)) in all.iter().zip(walked).enumerate() {
        let (_, result) = walked?;
        for row in 0..rows {
            let to = &mut found.columns[(row * columns + column) * results..][..results];
            let [new, old] =
                [&result, &found.result].map(|r| &r[row * results..(row + 1) * results]);
            to.iter_mut()
                .zip(new.iter().zip(old))
                .for_each(|(to, (new, old))| *to = (new - old) / step);
        }
    }
    Some(found)
}

/// Whether the states are those of the motion, and not just those that a run has begun with.
fn shows_its_states(x: &[f64], nx: usize) -> bool {
    x.chunks_exact(nx.max(1)).any(|row| row != &x[..nx])
}

/// What is moved in a run: one state, input or force in each step, or a parameter all along.
struct Moved {
    x: Option<(usize, f64)>,
    u: Option<(usize, f64)>,
    f: Option<(usize, f64)>,
    theta: Vec<f64>,
}

/// Everything that can be moved, and how far.
fn all_moved(
    simulator: &dyn Simulator,
    found: &Slopes,
    forces: &[f64],
    part: f64,
) -> Vec<(Moved, f64)> {
    let [nx, nu, nf, _] = found.widths;
    let theta = &found.theta;
    let plain = || Moved { x: None, u: None, f: None, theta: theta.clone() };
    let states = (0..nx).map(|i| {
        let tolerance = simulator.initial()[i].tolerance;
        let step = part * size(&found.x, nx, i, tolerance);
        (Moved { x: Some((i, step)), ..plain() }, step)
    });
    let inputs = (0..nu).map(|i| {
        let step = part * size(&found.u, nu, i, None);
        (Moved { u: Some((i, step)), ..plain() }, step)
    });
    let ports = (0..nf).map(|i| {
        let usual = forces.get(i).copied().filter(|f| f.is_finite() && 0.0 < *f);
        let step = part * usual.unwrap_or(1.0);
        (Moved { f: Some((i, step)), ..plain() }, step)
    });
    let parameters = (0..theta.len()).map(|i| {
        let step = nudge(simulator, i, theta[i]);
        let mut theta = theta.clone();
        theta[i] += step;
        (Moved { theta, ..plain() }, step)
    });
    states.chain(inputs).chain(ports).chain(parameters).collect()
}

/// What column `i` of signals usually does: its range, or its tolerance or a part of its size where it rests.
fn size(rows: &[f64], width: usize, i: usize, tolerance: Option<f64>) -> f64 {
    let column = || rows.iter().skip(i).step_by(width).copied();
    let (low, high) =
        (column().fold(f64::INFINITY, f64::min), column().fold(f64::NEG_INFINITY, f64::max));
    let largest = low.abs().max(high.abs());
    let range = (high - low).max(tolerance.unwrap_or(0.0)).max(STEP * largest);
    if 0.0 < range && range.is_finite() { range } else { 1.0 }
}

/// States before the steps, and outputs and states after each of them.
type Walked = (Vec<f64>, Vec<f64>);

/// Steps through the replays with something moved; from the states of `along` in each step, if these are given.
fn walk(
    simulator: &mut dyn Simulator,
    replays: &[Replay<'_>],
    steps: usize,
    moved: &Moved,
    along: Option<&[f64]>,
) -> Option<Walked> {
    let (nx, nu, ny) =
        (simulator.initial().len(), simulator.inputs().len(), simulator.outputs().len());
    let mut f = vec![0.0; simulator.ports().len()];
    let (mut states, mut results) = (Vec::new(), Vec::new());
    let mut y = vec![0.0; ny];
    let mut u = vec![0.0; nu];
    let mut row = 0;
    for replay in replays {
        simulator.start(&moved.theta, &replay.start(simulator), replay.begin(steps));
        for k in 0..replay.samples * steps {
            u.copy_from_slice(replay.input(k, steps, nu));
            replay.force(k, &mut f);
            for (row, moved) in [(&mut u, moved.u), (&mut f, moved.f)] {
                if let Some((i, step)) = moved {
                    row[i] += step;
                }
            }
            if let Some(along) = along {
                let mut x = along[row * nx..(row + 1) * nx].to_vec();
                if let Some((i, step)) = moved.x {
                    x[i] += step;
                }
                // What cannot be moved in mid-run is started there.
                if !simulator.go_on_from(&x) {
                    simulator.start(&moved.theta, &x, replay.begin(steps) + k as u64);
                }
            }
            states.extend_from_slice(simulator.state());
            simulator.step(&u, &u, &f, &mut y);
            results.extend_from_slice(&y);
            results.extend_from_slice(simulator.state());
            row += 1;
        }
        simulator.rest();
    }
    results.iter().all(|value| value.is_finite()).then_some((states, results))
}
