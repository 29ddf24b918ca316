//! Inputs in a wrong unit, and swapped columns: tried out in the simulation.

use fd_sim::simulate::Simulator;

use super::{agreement::agreement, finding::Defect};
use crate::fit::Log;

/// Part of the disagreement of the outputs, all together, that a change of inputs may leave.
const BETTER: f64 = 0.2;
/// Least disagreement, on average, to speak of.
const BAD: f64 = 0.05;
/// How well each output must agree then, on average.
const GOOD: f64 = 0.8;
/// How little an output agrees with the simulation when it is taken for an input.
const POOR: f64 = 0.3;
/// Factors of a wrong unit.
const FACTORS: [f64; 2] = [1e-3, 1e3];

/// What inputs of the log would make the nominal simulation agree with it, by place of the input.
pub(super) fn input_defects(
    simulator: &dyn Simulator,
    log: &Log,
    known: usize,
) -> Vec<(usize, Defect)> {
    let mut simulator = simulator.boxed();
    let theta: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
    let x0: Vec<f64> = simulator.initial().iter().map(|state| state.value).collect();
    let names: Vec<String> = simulator.inputs().iter().map(|input| input.name.clone()).collect();
    let outputs: Vec<String> = simulator.outputs().iter().map(|y| y.name.clone()).collect();
    let mut y = vec![0.0; log.y.len()];
    let mut total = |u: &[f64]| -> f64 {
        // What diverges is NaN, and agrees with nothing.
        let _ = simulator.simulate(&theta, &x0, u, &mut y);
        let column = |values: &[f64], c: usize| -> Vec<f64> {
            values.iter().skip(c).step_by(log.ny).copied().collect()
        };
        (0..log.ny).map(|c| agreement(&column(&log.y, c), &column(&y, c))).sum()
    };
    let as_it_is = total(&log.u);
    // What an input that does not move at all would do: a factor near zero must do better than that.
    let still: Vec<f64> = (0..log.nu)
        .map(|i| {
            let mut u = log.u.clone();
            u.iter_mut().skip(i).step_by(log.nu).for_each(|u| *u = 0.0);
            total(&u)
        })
        .collect();
    let all = log.ny as f64;
    let mut good = |u: &[f64]| {
        let changed = total(u);
        let left = all - changed;
        let is_good =
            BAD * all < all - as_it_is && left < BETTER * (all - as_it_is) && GOOD * all < changed;
        is_good.then_some(changed)
    };
    let mut found = Vec::new();
    for (i, still) in still.into_iter().enumerate().take(known) {
        for factor in FACTORS {
            let mut u = log.u.clone();
            u.iter_mut().skip(i).step_by(log.nu).for_each(|u| *u *= factor);
            if good(&u).is_some_and(|agreement| is_moved(agreement, still, all)) {
                found.push((i, Defect::WrongUnit { factor }));
            }
        }
        for (j, with) in names.iter().enumerate().take(known).skip(i + 1) {
            let mut u = log.u.clone();
            for row in u.chunks_exact_mut(log.nu) {
                row.swap(i, j);
            }
            if good(&u).is_some() {
                found.push((i, Defect::Swapped { with: with.clone() }));
            }
        }
    }
    for i in 0..known.min(log.nu) {
        for c in (0..log.ny).filter(|c| crossed(&mut *simulator, log, i, *c)) {
            found.push((i, Defect::Swapped { with: outputs[c].clone() }));
        }
    }
    found
}

/// Whether the outputs agree with an input clearly better than with one that stands still.
fn is_moved(agreement: f64, still: f64, all: f64) -> bool {
    all - agreement < BETTER * (all - still)
}

/// Whether the column of an output, as an input, moves the simulated output as the column of the
/// input shows; and as they are, the columns have nothing to do with each other.
fn crossed(simulator: &mut dyn Simulator, log: &Log, input: usize, output: usize) -> bool {
    let theta: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
    let x0: Vec<f64> = simulator.initial().iter().map(|state| state.value).collect();
    let column = |values: &[f64], width: usize, i: usize| -> Vec<f64> {
        values.iter().skip(i).step_by(width).copied().collect()
    };
    let (given, shown) = (column(&log.u, log.nu, input), column(&log.y, log.ny, output));
    let mut agree = |u: &[f64], wanted: &[f64]| {
        let mut all = log.u.clone();
        let mut last = 0.0;
        for (k, value) in u.iter().enumerate() {
            // A hole is bridged, as an input cannot have one.
            last = if value.is_finite() { *value } else { last };
            all[k * log.nu + input] = last;
        }
        let mut y = vec![0.0; log.y.len()];
        let _ = simulator.simulate(&theta, &x0, &all, &mut y);
        agreement(wanted, &column(&y, log.ny, output))
    };
    agree(&given, &shown) < POOR && GOOD < agree(&shown, &given)
}
