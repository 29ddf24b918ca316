//! How well a linear model predicts a run of the simulator.

use super::replay::Replay;
use crate::simulate::{Run, Simulator, Tape};

/// How far inputs and forces are disturbed, as a part of their size …
const DISTURBED: f64 = 0.1;
/// … and for how many steps into one direction.
const HOLD: usize = 16;

/// Share of the change of the outputs by a disturbance of inputs, forces and parameters that is foretold, from 0
/// to 1; 0 when a run diverges.
pub(super) fn explained(
    simulator: &dyn Simulator,
    linear: &dyn Simulator,
    replays: &[Replay<'_>],
    steps: usize,
    forces: &[f64],
    nominal: &[f64],
) -> f64 {
    let parameters = simulator.parameters().iter().enumerate();
    let theta: Vec<f64> = parameters
        .map(|(i, p)| {
            let moved = nominal[i] * (1.0 + 0.5 * p.tolerance * sign(i, 0));
            p.bounds.map_or(moved, |[low, high]| moved.clamp(low, high))
        })
        .collect();
    let (mut real, mut still) = (simulator.boxed(), linear.boxed());
    let mut linear = linear.boxed();
    let (nu, ny) = (simulator.inputs().len(), simulator.outputs().len());
    let nf = simulator.ports().len();
    let size = |i: usize| {
        let column = replays.iter().flat_map(|r| r.u.iter().skip(i).step_by(nu));
        column.fold(0.0_f64, |most, u| most.max(u.abs()))
    };
    let sizes: Vec<f64> = (0..nu).map(size).collect();
    // Sums of squares per output: of what is not foretold, and of the change.
    let mut squares = vec![[0.0; 2]; ny];
    let mut begin = 0;
    for replay in replays {
        let x0 = replay.start(simulator);
        linear.start(&theta, &x0, replay.begin(steps));
        still.start(nominal, &x0, replay.begin(steps));
        let [mut foretold, mut undisturbed] = [(); 2].map(|()| vec![0.0; ny]);
        let n = replay.samples * steps;
        let (mut u, mut f) = (Vec::with_capacity(n * nu), replay.forces(steps, nf));
        for (k, f) in f.chunks_exact_mut(nf.max(1)).enumerate() {
            for (i, (f, usual)) in f.iter_mut().zip(forces).enumerate() {
                *f += DISTURBED * usual * sign(nu + i, 1 + k / HOLD);
            }
        }
        for k in 0..n {
            let disturbed =
                |(i, u): (usize, &f64)| u + DISTURBED * sizes[i] * sign(i, 1 + k / HOLD);
            u.extend(replay.input(k, steps, nu).iter().enumerate().map(disturbed));
        }
        // In one go: a simulator that makes whole runs only is not asked for steps.
        let mut y = vec![f64::NAN; n * ny];
        let run = Run::new(&theta, &x0, &mut y);
        real.replay(replay.begin(steps), &mut [Tape { run, u: &u, f: &f }]);
        let mut at_rest = vec![0.0; nf];
        for k in 0..n {
            let row = (begin + k / steps) as f64;
            replay.force(k, &mut at_rest);
            let with_row = |u: &[f64]| [u, &[row]].concat();
            let (plain, u) = (replay.input(k, steps, nu), &u[k * nu..(k + 1) * nu]);
            linear.step(&with_row(u), &with_row(u), &f[k * nf..(k + 1) * nf], &mut foretold);
            still.step(&with_row(plain), &with_row(plain), &at_rest, &mut undisturbed);
            for (c, squares) in squares.iter_mut().enumerate() {
                squares[0] += (y[k * ny + c] - foretold[c]).powi(2);
                squares[1] += (y[k * ny + c] - undisturbed[c]).powi(2);
            }
        }
        real.rest();
        begin += replay.samples;
    }
    // The run of the simulator and the one that it was linearised along differ by chance as well.
    let samples = (begin * steps) as f64;
    for (squares, spread) in squares.iter_mut().zip(simulator.spread()) {
        let by_chance = 2.0 * samples * spread * spread;
        for square in squares {
            *square = (*square - by_chance).max(0.0);
        }
    }
    let shares = squares.iter().filter(|[_, all]| 0.0 < *all).map(|[left, all]| 1.0 - left / all);
    let least = shares.fold(f64::INFINITY, f64::min);
    // What nothing moves says nothing; what diverges is not foretold.
    if squares.iter().flatten().all(|s| s.is_finite()) && least.is_finite() {
        least.max(0.0)
    } else {
        0.0
    }
}

/// A sign by chance, the same in every run: a hash of two numbers (the finaliser of `SplitMix64`).
fn sign(i: usize, k: usize) -> f64 {
    let mut h = ((i as u64) << 32 | k as u64).wrapping_add(0x9e37_79b9_7f4a_7c15);
    h = (h ^ (h >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    h = (h ^ (h >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    if (h ^ (h >> 31)) & 1 == 0 { 1.0 } else { -1.0 }
}
