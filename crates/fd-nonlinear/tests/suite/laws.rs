//! What every filter owes: its memory, and composure where the model has no answer.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use crate::common::{TANKS, noisy, residuals, run};
use fd_core::{
    Frame, Snapshot,
    stage::{ResidualGenerator, Stage},
    testing::{memory, nonsense},
};
use fd_nonlinear::{Noise, NoisyModel, testing::every_filter};

fn tanks() -> NoisyModel {
    let noise = Noise { process: vec![0.01; 2], output: vec![0.02], initial: vec![0.1; 2] };
    noisy(TANKS, noise)
}

fn samples(count: usize) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let u: Vec<Vec<f64>> = (0..count).map(|k| vec![0.1 + 0.03 * (0.05 * k as f64).sin()]).collect();
    let (_, y) = run(&tanks(), &u, 11);
    (u, y)
}

fn step(generator: &mut Box<dyn ResidualGenerator>, u: &[f64], y: &[f64]) -> Vec<u64> {
    let mut r = vec![0.0; generator.residual_len()];
    generator.step(Frame::new(generator.io(), 0, u, y).unwrap(), &mut r);
    r.iter().map(|r| r.to_bits()).collect()
}

#[test]
fn memory_is_shown_whole() {
    let (u, y) = samples(80);
    let twins = every_filter(&tanks()).unwrap();
    for ((_, mut filter), (_, mut twin)) in every_filter(&tanks()).unwrap().into_iter().zip(twins) {
        memory(&mut filter, &mut twin, 80, |filter, k| step(filter, &u[k], &y[k]));
    }
}

#[test]
fn no_memory_makes_a_filter_panic() {
    let (u, y) = samples(20);
    for (_, mut filter) in every_filter(&tanks()).unwrap() {
        nonsense(&mut filter, 20, |filter, k| step(filter, &u[k], &y[k]));
    }
}

/// A level below the bottom has no root: the residual says so, and the filter is back when the plant is.
#[test]
fn a_model_without_an_answer_is_said_and_survived() {
    let (u, mut y) = samples(400);
    // A sensor that reads far below the bottom drags the estimate there.
    y[100..110].iter_mut().for_each(|y| y[0] = -50.0);
    for (name, mut filter) in every_filter(&tanks()).unwrap() {
        let r = residuals(&mut *filter, &u, &y);
        let is_lost = r[100..130].iter().any(|r| r[0].is_nan());
        // Particles that are of no use die out; none of the others is ever asked for the root of nothing.
        assert!(is_lost || name == "particle", "{name} has not noticed");
        assert!(r[..100].iter().chain(&r[200..]).all(|r| r[0].abs() < 0.3), "{name} is not back");
        // Whatever happened, the memory is one that can be saved and restored.
        let saved = Snapshot::of(&mut filter);
        saved.restore(&mut filter).unwrap();
        filter.reset();
        assert_eq!(residuals(&mut *filter, &u[..50], &y[..50]), r[..50], "{name}");
    }
}
