//! On the plant that a filter believes in, its innovations are white; those of a filter on a linearised
//! model are not, once the plant leaves its operating point.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use crate::common::{TANKS, map, noisy, residuals, run};
use fd_core::{Heap, stage::ResidualGenerator};
use fd_model::SampleTime;
use fd_nonlinear::{
    Noise, NoisyModel, OperatingPoint, PlantEquations, extended::ExtendedDesign, linearise,
    particle::ParticleDesign, unscented::UnscentedDesign,
};

const LAGS: usize = 10;
const SEEDS: u64 = 10;

fn noise() -> Noise {
    Noise { process: vec![2e-3; 2], output: vec![5e-3], initial: vec![0.05; 2] }
}

/// Levels from a third of a metre to three.
fn inputs(samples: usize) -> Vec<Vec<f64>> {
    (0..samples).map(|k| vec![0.115 + 0.055 * (0.01 * k as f64).sin()]).collect()
}

/// The portmanteau statistic of Ljung and Box (1978) over all seeds: of white noise it has the law of χ² with
/// `LAGS · SEEDS` degrees of freedom.
fn statistic(
    mut make: impl FnMut() -> Box<dyn ResidualGenerator>,
    shift: f64,
    samples: usize,
) -> f64 {
    let model = noisy(TANKS, noise());
    let u = inputs(samples);
    let moved: Vec<Vec<f64>> = u.iter().map(|u| vec![u[0] - shift * 0.1]).collect();
    (0..SEEDS)
        .map(|seed| {
            let (_, y) = run(&model, &u, 900 + seed);
            let y: Vec<Vec<f64>> = y.iter().map(|y| vec![y[0] - shift]).collect();
            let r = residuals(&mut *make(), &moved, &y);
            let r: Vec<f64> = r.iter().skip(50).map(|r| r[0]).collect();
            let n = r.len() as f64;
            let power: f64 = r.iter().map(|r| r * r).sum();
            let share = |lag: usize| {
                let both = r.iter().zip(&r[lag..]);
                both.map(|(a, b)| a * b).sum::<f64>() / power
            };
            n * (n + 2.0) * (1..=LAGS).map(|lag| share(lag).powi(2) / (n - lag as f64)).sum::<f64>()
        })
        .sum()
}

/// Between the 0.05 % and the 99.95 % quantile of χ² with 100 degrees of freedom.
const WHITE: [f64; 2] = [59.9, 153.2];

fn is_white(statistic: f64) -> bool {
    WHITE[0] < statistic && statistic < WHITE[1]
}

#[test]
fn innovations_are_white() {
    let model = || noisy(TANKS, noise());
    let extended = statistic(|| Box::new(ExtendedDesign::new(model()).freeze()), 0.0, 1000);
    assert!(is_white(extended), "extended: {extended}");
    // Half a wave of the level takes 314 samples.
    let in_turns = statistic(
        || Box::new(ExtendedDesign::new(model()).linearised_over(10).freeze()),
        0.0,
        1000,
    );
    assert!(is_white(in_turns), "extended, slopes in turns: {in_turns}");
    let unscented =
        statistic(|| Box::new(UnscentedDesign::new(model(), None).unwrap().freeze()), 0.0, 1000);
    assert!(is_white(unscented), "unscented: {unscented}");
    let particle =
        statistic(|| Box::new(ParticleDesign::new(model(), 500, 3).unwrap().freeze()), 0.0, 300);
    assert!(is_white(particle), "particle: {particle}");
}

/// The same filter on the model linearised at one metre, with all signals as deviations from there.
#[test]
fn those_of_a_linearised_model_are_not() {
    let at = OperatingPoint { x: vec![1.0; 2], u: vec![0.1], dx: vec![1.0; 2], du: vec![0.1] };
    let linear = linearise(&map(TANKS), &at, SampleTime::new(1.0).unwrap()).unwrap();
    let make = || -> Box<dyn ResidualGenerator> {
        let equations = PlantEquations::new(linear.freeze::<f64, Heap>().unwrap());
        let model = NoisyModel::new(equations, vec![0.0; 2], noise()).unwrap();
        Box::new(ExtendedDesign::new(model).freeze())
    };
    let found = statistic(make, 1.0, 1000);
    assert!(found > 10.0 * WHITE[1], "{found}");
}
