//! Runs in which what drives a simulator depends on its outputs, of one that makes whole runs only.
//!
//! Waveform relaxation (Lelarasmee, Ruehli and Sangiovanni-Vincentelli 1982) around a linear model. A pass goes through
//! the equations of the shell with outputs that are foretold: those of the last whole run, and what difference
//! equations say of being driven otherwise than in it. Then a whole run is made with what came out. Where a pass drives
//! the simulator as the last run did, to the bit, outputs are those of steps; each pass makes one further sample so at
//! least, and all of them where the plant is linear. Forces see the outputs of their own sample.
//!
//! *When not to use:* where steps can be asked for. Outputs are those of steps to within [`SETTLED`] only, and where the
//! linear model says little of the plant, a run may take as many passes as it has samples.

use std::sync::Arc;

use super::{super::loan::Shared, OutsideSimulator, replay::replay};
use crate::simulate::{Changes, DifferenceEquation, Driven, Run, Settled, Simulator, Tape};

/// Outputs are settled when the next pass would change them by less than this part of their range …
pub(super) const SETTLED: f64 = 1e-6;
/// … or than so many times their rounding …
const ROUNDINGS: f64 = 4.0;
/// … or when a pass changed them by less than so much more, and at least half as much as the one before: what rounding
/// changes does not get smaller.
const STUCK: f64 = 100.0;
/// A change becomes smaller by what it became in the last run, or by so many times less.
const SLOWER: f64 = 10.0;

/// A run that is not settled yet.
struct Open {
    lane: usize,
    theta: Vec<f64>,
    x0: Vec<f64>,
    /// Inputs and forces of the last whole run, and its outputs, row by row.
    u: Vec<f64>,
    f: Vec<f64>,
    y: Vec<f64>,
    /// What the last pass changed of the outputs, in units of what is settled.
    changed: Option<f64>,
    /// Ratio of the changes of two passes: in a run like this one, and the largest one in this one.
    known_rate: Option<f64>,
    rate: Option<f64>,
}

/// How a pass ended.
enum Passed {
    Settled {
        u: Vec<f64>,
        f: Vec<f64>,
        rate: f64,
    },
    /// The run diverges.
    Lost,
    /// Drives the simulator by other inputs and forces, and changes outputs by so much.
    Otherwise {
        u: Vec<f64>,
        f: Vec<f64>,
        change: f64,
        rate: Option<f64>,
    },
}

/// Makes the runs of all lanes.
pub(super) fn settle(
    shared: &Arc<Shared>,
    responses: &Arc<[DifferenceEquation]>,
    first: u64,
    lanes: &mut [Box<dyn Driven + '_>],
) {
    let mut simulator = OutsideSimulator::of(Arc::clone(shared));
    let nf = shared.contract.ports.len();
    let precision = simulator.precision();
    let mut changes = Changes::new(Arc::clone(responses));
    let mut open: Vec<Open> = lanes
        .iter_mut()
        .enumerate()
        .map(|(lane, driven)| {
            driven.begin();
            let (theta, x0) = (driven.theta().to_vec(), driven.x0().to_vec());
            let steps = driven.steps();
            let y = vec![f64::NAN; steps * shared.contract.outputs.len()];
            // From what drove a run like this one, or as if nothing depended on outputs.
            let known = driven.remembered().filter(|known| known.f.len() == steps * nf).cloned();
            let known_rate = known.as_ref().map(|known| known.rate);
            let (u, f) = match known {
                Some(known) => (known.u, known.f),
                None => (inputs(&**driven), vec![0.0; steps * nf]),
            };
            Open { lane, theta, x0, u, f, y, changed: None, known_rate, rate: None }
        })
        .collect();
    // Each pass makes a sample right, unless outputs depend on forces of their own sample: then it need not end.
    let most = lanes.iter().map(|lane| lane.steps()).max().unwrap_or(0) + 2;
    for _ in 0..most {
        let each = open.iter_mut();
        let mut tapes: Vec<Tape<'_>> = each
            .map(|Open { theta, x0, u, f, y, .. }| Tape { run: Run::new(theta, x0, y), u, f })
            .collect();
        replay(&mut simulator, first, &mut tapes);
        drop(tapes);
        open.retain_mut(|open| {
            let lane = &mut *lanes[open.lane];
            match open.pass(lane, &mut changes, precision) {
                Passed::Settled { u, f, rate } => {
                    lane.remember(Settled { u, f, rate });
                    false
                }
                Passed::Lost => false,
                Passed::Otherwise { u, f, change, rate } => {
                    (open.u, open.f, open.changed, open.rate) = (u, f, Some(change), rate);
                    true
                }
            }
        });
        if open.is_empty() {
            return;
        }
    }
    for Open { lane, .. } in open {
        lanes[lane].begin();
        lanes[lane].take(0, &vec![f64::NAN; shared.contract.outputs.len()]);
    }
}

impl Open {
    /// Goes through a lane with the outputs that are foretold; those of whole runs are rounded to this part.
    fn pass(&self, lane: &mut dyn Driven, changes: &mut Changes, precision: f64) -> Passed {
        let steps = lane.steps().max(1);
        let [nu, nf, ny] = [&self.u, &self.f, &self.y].map(|rows| rows.len() / steps);
        let settled = settled(&self.y, ny, precision);
        // Behind a divergence, all that is known of the plant is how it is driven from outside.
        let (mut u, mut f) = (inputs(lane), vec![0.0; self.f.len()]);
        let (mut w, mut y) = (vec![0.0; nu + nf], vec![0.0; ny]);
        let (mut change, mut is_same, mut is_whole) = (0.0_f64, true, true);
        lane.begin();
        changes.rest();
        for k in 0..lane.steps() {
            let (now_u, now_f) = (&mut u[k * nu..(k + 1) * nu], &mut f[k * nf..(k + 1) * nf]);
            let known = &self.y[k * ny..(k + 1) * ny];
            w.fill(0.0);
            let seen = y.iter_mut().zip(known).zip(changes.of(&w));
            seen.for_each(|((y, known), by)| *y = known + by);
            if y.iter().any(|seen| !seen.is_finite()) {
                // The last run has diverged: so does the lane, if it was driven as that so far.
                is_whole = false;
                if is_same {
                    lane.take(k, &y);
                }
                break;
            }
            lane.drive(k, Some(&y), now_u, now_f);
            let now = now_u.iter().chain(&*now_f);
            let before = self.u[k * nu..(k + 1) * nu].iter().chain(&self.f[k * nf..(k + 1) * nf]);
            w.iter_mut().zip(now.zip(before)).for_each(|(w, (now, before))| *w = now - before);
            is_same = is_same && w.iter().all(|w| *w == 0.0);
            let each = y.iter_mut().zip(known).zip(changes.of(&w).iter().zip(&settled));
            for ((y, known), (by, settled)) in each {
                *y = known + by;
                change = change.max(by.abs() / settled);
            }
            changes.move_on();
            if !lane.take(k, &y) {
                is_whole = false;
                break;
            }
        }
        if is_same && !is_whole {
            return Passed::Lost;
        }
        let before = self.changed.filter(|before| before.is_finite());
        let seen = before.map(|before| (change / before).min(1.0));
        // The next change is smaller than this one, in orders of magnitude half as much as this is than the last; or as
        // runs like this one have shown.
        let next = match (seen, self.known_rate) {
            (Some(seen), _) => change * seen.sqrt(),
            (None, Some(rate)) => change * (SLOWER * rate).min(1.0),
            (None, None) => change,
        };
        let rate = [seen, self.rate].into_iter().flatten().reduce(f64::max);
        let is_stuck = seen.is_some_and(|seen| 0.5 < seen) && change < STUCK;
        if is_same || is_whole && (next < 1.0 || is_stuck) {
            let rate = rate.or(self.known_rate).unwrap_or(1.0);
            return Passed::Settled { u, f, rate };
        }
        Passed::Otherwise { u, f, change: if is_whole { change } else { f64::INFINITY }, rate }
    }
}

/// The inputs that a lane gets from outside, row by row.
fn inputs(lane: &dyn Driven) -> Vec<f64> {
    (0..lane.steps()).flat_map(|k| lane.input(k)).copied().collect()
}

/// By how much each column may still change.
fn settled(rows: &[f64], width: usize, precision: f64) -> Vec<f64> {
    let of_column = |i: usize| {
        let column = rows.iter().skip(i).step_by(width.max(1)).filter(|value| value.is_finite());
        let (least, most, size) = column.fold((f64::MAX, f64::MIN, 0.0_f64), |(l, m, s), v| {
            (l.min(*v), m.max(*v), s.max(v.abs()))
        });
        // What stays the same is settled when it still does.
        let range = if least < most {
            most - least
        } else if 0.0 < size {
            size
        } else {
            1.0
        };
        (SETTLED * range).max(ROUNDINGS * precision * size)
    };
    (0..width).map(of_column).collect()
}
