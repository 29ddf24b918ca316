//! How long a simulator remembers its initial state, along the inputs of a log.

use fd_sim::simulate::{Simulator, walk};
use schemars::JsonSchema;
use serde::Serialize;

/// How long a simulator remembers its initial state.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Memory {
    /// Longest time, in seconds, after which the effect of an initial state on the outputs has
    /// fallen to 1/e of its largest and stays below; of those states that are forgotten within a
    /// third of the log. `None` when there is no such state.
    pub seconds: Option<f64>,
    /// Whether all states are forgotten within a third of the log.
    pub forgets: bool,
    /// Longest time constant, in seconds, of those states that are forgotten so slowly that the log
    /// ends before; `None` when there is no such state, or it is never forgotten.
    pub slowest: Option<f64>,
    /// Whether a small change of some initial state grows so much that a run through the whole log is
    /// lost: an unstable plant, not one that merely integrates.
    pub runs_away: bool,
}

/// Part of the log within which a state must be forgotten.
const SHARE: f64 = 3.0;
/// Growth of a distance, from the first quarter of the log to the last one, of what runs away. An
/// integrator grows by a factor of 4, two in a row by one of 16.
const RUNS_AWAY: f64 = 100.0;
/// Ratio of the falls from one quarter to the next up to which a decay is one.
const EVEN: f64 = 1.5;
/// Change of a state, as a fraction of its range in the log or of its size.
const NUDGE: f64 = 1e-4;

impl Memory {
    /// Changes each initial state a little and watches the outputs. `u` are the inputs of
    /// `samples` samples.
    pub(super) fn of(simulator: &dyn Simulator, u: &[f64], samples: usize) -> Self {
        let mut simulator = simulator.boxed();
        let theta: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
        let x0: Vec<f64> = simulator.initial().iter().map(|state| state.value).collect();
        let (nx, ny) = (x0.len(), simulator.outputs().len());
        let mut base = vec![0.0; samples * ny];
        let range = ranges(&mut *simulator, &theta, &x0, u, &mut base);
        let scale: Vec<f64> = (0..ny).map(|c| spread(base.iter().skip(c).step_by(ny))).collect();
        let mut memory = Self { seconds: None, forgets: true, slowest: None, runs_away: false };
        let mut y = vec![0.0; samples * ny];
        for i in 0..nx {
            let mut nudged = x0.clone();
            nudged[i] += NUDGE * range[i].max(x0[i].abs()).max(1e-6);
            // A simulation that diverges is NaN, and never forgotten.
            let _ = simulator.simulate(&theta, &nudged, u, &mut y);
            let distance: Vec<f64> = (0..samples)
                .map(|k| {
                    let row = (0..ny).map(|c| (y[k * ny + c] - base[k * ny + c]) / scale[c]);
                    row.map(|d| d * d).sum::<f64>().sqrt()
                })
                .collect();
            let largest = distance.iter().copied().fold(0.0, f64::max);
            let is_kept = |d: &f64| d.is_nan() || largest / std::f64::consts::E < *d;
            let kept = distance.iter().rposition(is_kept).map_or(0, |last| last + 1);
            if SHARE * kept as f64 <= samples as f64 {
                let seconds = kept as f64 * simulator.ts().seconds();
                memory.seconds = Some(memory.seconds.unwrap_or(0.0).max(seconds));
            } else if largest > 0.0 || distance.iter().any(|d| d.is_nan()) {
                memory.forgets = false;
                memory.runs_away |= runs_away(&distance);
                let slow = slow(&distance, simulator.ts().seconds());
                memory.slowest = [memory.slowest, slow].into_iter().flatten().reduce(f64::max);
            }
        }
        memory
    }
}

/// Range of each state in the simulation, of which the outputs are written.
fn ranges(
    simulator: &mut dyn Simulator,
    theta: &[f64],
    x0: &[f64],
    u: &[f64],
    y: &mut [f64],
) -> Vec<f64> {
    let mut ends = vec![[f64::INFINITY, f64::NEG_INFINITY]; x0.len()];
    // A run that diverges is NaN from there on.
    let _ = walk(simulator, theta, x0, 0, u, y, |_, x| {
        for (ends, x) in ends.iter_mut().zip(x) {
            *ends = [ends[0].min(*x), ends[1].max(*x)];
        }
    });
    ends.iter().map(|[low, high]| (high - low).max(0.0)).collect()
}

/// Standard deviation; 1 for what does not move.
fn spread<'a>(values: impl Iterator<Item = &'a f64> + Clone) -> f64 {
    let [_, deviation] = fd_numeric::mean_and_deviation(values.copied());
    if 0.0 < deviation { deviation } else { 1.0 }
}

/// Whether a distance grows without end, or to none that is a number.
fn runs_away(distance: &[f64]) -> bool {
    let quarter = distance.len() / 4;
    let largest = |part: &[f64]| part.iter().copied().fold(0.0, f64::max);
    let (first, last) = (largest(&distance[..quarter]), largest(&distance[3 * quarter..]));
    distance.iter().any(|d| d.is_nan()) || RUNS_AWAY * first < last
}

/// Time constant of a distance that decays slowly, from its largest values in the second, third and last
/// quarters of the log. What falls by less than a hundredth from one to the next, or grows, has none; nor has
/// what falls unevenly, as the ripple of an integrator may by chance.
fn slow(distance: &[f64], ts: f64) -> Option<f64> {
    let quarter = distance.len() / 4;
    let largest = |i: usize| -> Option<f64> {
        let part = distance.get(i * quarter..((i + 1) * quarter))?;
        Some(part.iter().copied().fold(0.0, f64::max))
    };
    let [second, third, last] = [largest(1)?, largest(2)?, largest(3)?];
    let falls = [(second / third).ln(), (third / last).ln()];
    let [less, more] = [falls[0].min(falls[1]), falls[0].max(falls[1])];
    (0.01 < less && more < EVEN * less).then(|| quarter as f64 * ts / (0.5 * (less + more)))
}
