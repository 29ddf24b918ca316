//! How far initial states matter that a simulator does not show.

use fd_sim::simulate::{Outcome, Run, Simulator};

use super::log::Log;

/// First change of a state, in its size, its tolerance or one.
const NUDGE: f64 = 1e-2;
/// Outputs that change by less than this part of their range are moved further: rounding may be as large …
const LITTLE: f64 = 1e-3;
/// … and by more than so many ranges, less far.
const MUCH: f64 = 10.0;
/// Factor to the next try …
const FACTOR: f64 = 30.0;
/// … of so many.
const TRIES: usize = 5;

/// By how much each initial state has to be moved for some output to move by its range in the run through a log, of
/// which `y` are the outputs; `None` for one that moves nothing.
///
/// A state that is shown has a range of its own; this stands for it where there is none to see.
pub(super) fn scales(
    simulator: &mut dyn Simulator,
    theta: &[f64],
    initial: &[(f64, Option<f64>)],
    log: &Log,
    y: &[f64],
) -> Vec<Option<f64>> {
    let x0: Vec<f64> = initial.iter().map(|(value, _)| *value).collect();
    let ranges: Vec<f64> = (0..log.ny).map(|c| range(y.iter().skip(c).step_by(log.ny))).collect();
    let size = |(value, tolerance): &(f64, Option<f64>)| {
        let size = value.abs().max(tolerance.unwrap_or(0.0));
        NUDGE * if 0.0 < size { size } else { 1.0 }
    };
    let mut steps: Vec<f64> = initial.iter().map(size).collect();
    let mut found = vec![None; x0.len()];
    let mut open: Vec<usize> = (0..x0.len()).collect();
    for _ in 0..TRIES {
        if open.is_empty() {
            break;
        }
        let moved = |&i: &usize| {
            let mut moved = x0.clone();
            moved[i] += steps[i];
            moved
        };
        let starts: Vec<Vec<f64>> = open.iter().map(moved).collect();
        let mut outputs = vec![vec![0.0; y.len()]; open.len()];
        let each = starts.iter().zip(&mut outputs);
        let mut runs: Vec<Run<'_>> = each.map(|(x0, y)| Run::new(theta, x0, y)).collect();
        simulator.simulate_many(0, &log.u, &mut runs);
        let ends: Vec<Outcome> = runs.iter().map(|run| run.outcome).collect();
        let mut again = Vec::new();
        for (i, (there, end)) in open.into_iter().zip(outputs.iter().zip(ends)) {
            let parts = there.iter().zip(y).enumerate();
            let parts = parts.map(|(k, (a, b))| (a - b).abs() / ranges[k % log.ny]);
            let most = if end == Outcome::Complete { parts.fold(0.0, f64::max) } else { f64::MAX };
            if 0.0 < most && most < f64::MAX {
                found[i] = Some(steps[i] / most);
            }
            if !(LITTLE..MUCH).contains(&most) {
                steps[i] *= if most < LITTLE { FACTOR } else { 1.0 / FACTOR };
                again.push(i);
            }
        }
        open = again;
    }
    found
}

/// Range of a signal; its size where it stays the same, or one.
fn range<'a>(values: impl Iterator<Item = &'a f64> + Clone) -> f64 {
    let ends = [f64::INFINITY, f64::NEG_INFINITY];
    let [low, high] = values.clone().fold(ends, |[l, h], v| [l.min(*v), h.max(*v)]);
    let size = values.fold(0.0_f64, |size, v| size.max(v.abs()));
    if low < high {
        high - low
    } else if 0.0 < size {
        size
    } else {
        1.0
    }
}
