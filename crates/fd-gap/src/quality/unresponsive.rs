//! Outputs that do not respond to an input: a drive that is off, braked or unplugged.

use fd_sim::simulate::Simulator;

use super::pattern::{normalised, remove};
use crate::fit::Log;

/// Past samples of the output from which it is foreseen.
const OWN: usize = 6;
/// Past stretches of an input, in samples: each twice as long as the one before.
const STRETCHES: [[usize; 2]; 7] = [[1, 1], [2, 2], [3, 4], [5, 8], [9, 16], [17, 32], [33, 64]];
/// Fewest rows to judge by.
const FEWEST: usize = 200;
/// Twice the logarithm of the likelihood ratio below which the past of an input says nothing: seven numbers that say nothing
/// reach it once in a thousand logs.
const SAYS: f64 = 24.3;
/// Part of a stretch of an input that must not follow from the rest of the log; else a loop hides what it does.
const OWN_PART: f64 = 0.01;

/// Pairs of an input (one of the first `known`) and an output of a log where the past of the input says nothing about the output beyond
/// what its own past says (Granger 1969), while the nominal simulation lets the input move the output by more than
/// all that was measured. What a controller makes of the noise of an output follows from the past of that, so that loops are
/// no exception.
pub(super) fn unresponsive(simulator: &dyn Simulator, log: &Log, known: usize) -> Vec<[usize; 2]> {
    let column = |values: &[f64], width: usize, i: usize| -> Vec<f64> {
        values.iter().skip(i).step_by(width).copied().collect()
    };
    let known = known.min(log.nu);
    if log.samples() < FEWEST {
        return Vec::new();
    }
    let inputs: Vec<Vec<f64>> = (0..known).map(|i| column(&log.u, log.nu, i)).collect();
    let mut simulator = simulator.boxed();
    let theta: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
    let x0: Vec<f64> = simulator.initial().iter().map(|state| state.value).collect();
    let mut run = |u: &[f64]| {
        let mut y = vec![0.0; log.y.len()];
        // What diverges is NaN, and has no spread.
        let _ = simulator.simulate(&theta, &x0, u, &mut y);
        y
    };
    let with = run(&log.u);
    let mut found = Vec::new();
    for i in 0..known {
        let [mean, spread] = moments(&inputs[i]);
        if spread <= 1e-9 * mean.abs() {
            continue;
        }
        let mut held = log.u.clone();
        held.iter_mut().skip(i).step_by(log.nu).for_each(|u| *u = mean);
        let without = run(&held);
        let moved: Vec<f64> = with.iter().zip(without).map(|(a, b)| a - b).collect();
        for c in 0..log.ny {
            let measured = column(&log.y, log.ny, c);
            let should = moments(&column(&moved, log.ny, c))[1];
            if moments(&measured)[1] < should && says_nothing(&measured, &inputs, i) {
                found.push([i, c]);
            }
        }
    }
    found
}

/// Mean and standard deviation of what is there.
fn moments(signal: &[f64]) -> [f64; 2] {
    fd_numeric::mean_and_deviation(signal.iter().copied().filter(|v| v.is_finite()))
}

/// Whether the past of an input does not help to foresee an output. Without an answer it is false.
fn says_nothing(output: &[f64], inputs: &[Vec<f64>], which: usize) -> bool {
    let first = STRETCHES[STRETCHES.len() - 1][1];
    let is_whole = |k: &usize| output[k - OWN..=*k].iter().all(|y| y.is_finite());
    let rows: Vec<usize> = (first..output.len()).filter(is_whole).collect();
    if rows.len() < FEWEST {
        return false;
    }
    let of = |value: &dyn Fn(usize) -> f64| rows.iter().map(|k| value(*k)).collect::<Vec<f64>>();
    let stretch = |input: &[f64], [from, to]: [usize; 2]| {
        of(&|k| input[k - to..=k - from].iter().sum::<f64>() / (to + 1 - from) as f64)
    };
    let own = (1..=OWN).map(|lag| of(&|k| output[k - lag]));
    let others = inputs.iter().enumerate().filter(|(i, _)| *i != which);
    let others = others.flat_map(|(_, input)| STRETCHES.map(|at| stretch(input, at)));
    let mut known: Vec<Vec<f64>> = Vec::new();
    let about_known = |column: &mut Vec<f64>, known: &[Vec<f64>]| {
        for unit in known {
            remove(unit, column);
        }
    };
    for mut column in std::iter::once(vec![1.0; rows.len()]).chain(own).chain(others) {
        about_known(&mut column, &known);
        known.extend(normalised(column));
    }
    let mut left = of(&|k| output[k]);
    about_known(&mut left, &known);
    let before = fd_numeric::wide::dot(&left, &left);
    let (mut tried, rest_of_log) = (0, known.len());
    for at in STRETCHES {
        let mut column = stretch(&inputs[which], at);
        remove(&known[0], &mut column);
        let all = fd_numeric::wide::dot(&column, &column);
        about_known(&mut column, &known[..rest_of_log]);
        if fd_numeric::wide::dot(&column, &column) <= OWN_PART * all {
            continue;
        }
        // What a smooth input does may show in the small differences of its stretches.
        about_known(&mut column, &known[rest_of_log..]);
        if let Some(unit) = normalised(column) {
            remove(&unit, &mut left);
            known.push(unit);
            tried += 1;
        }
    }
    let after = fd_numeric::wide::dot(&left, &left);
    let says = rows.len() as f64 * (before / after).ln();
    // Some of it must be seen by itself.
    STRETCHES.len() / 2 < tried && says < SAYS
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 11) as f64 / 2.0_f64.powi(53) - 0.5
        }
    }

    /// A lag that answers by a part of its command to what a proportional controller makes of noise and of a reference.
    fn log(gain: f64, loop_gain: f64) -> [Vec<f64>; 2] {
        let (mut white, mut other) = (noise(3), noise(7));
        let (mut x, mut colour, mut reference) = (0.0, 0.0, 0.0);
        let rows = (0..1000).map(|k| {
            colour = 0.8 * colour + white();
            if k % 40 == 0 {
                reference = 4.0 * other();
            }
            let y = x + colour;
            let u = reference - loop_gain * y;
            x += 0.1 * (gain * u - x);
            (u, y)
        });
        let (u, y) = rows.unzip();
        [u, y]
    }

    #[test]
    fn what_answers_at_all_responds() {
        for (gain, loop_gain) in [(1.0, 0.0), (0.3, 0.0), (1.0, 2.0), (0.3, 2.0)] {
            let [u, y] = log(gain, loop_gain);
            assert!(!says_nothing(&y, &[u], 0), "{gain} {loop_gain}");
        }
    }

    #[test]
    fn what_answers_to_the_rate_of_a_smooth_command_responds() {
        let (mut white, mut other) = (noise(3), noise(7));
        let (mut stages, mut x) = ([0.0; 3], 0.0);
        let rows = (0..1000).map(|_| {
            let before = stages[2];
            let mut input = 3.0 * other();
            for stage in &mut stages {
                *stage += 0.14 * (input - *stage);
                input = *stage;
            }
            x = 0.95 * x + 10.0 * (stages[2] - before);
            (stages[2], x + 0.02 * white())
        });
        let (u, y): (Vec<f64>, Vec<f64>) = rows.unzip();
        assert!(!says_nothing(&y, &[u], 0));
    }

    #[test]
    fn noise_does_not_respond_though_a_controller_follows_it() {
        for loop_gain in [0.0, 2.0] {
            let [u, y] = log(0.0, loop_gain);
            assert!(says_nothing(&y, &[u], 0), "{loop_gain}");
        }
    }
}
