//! The univariate non-stationary growth model of Gordon, Salmond and Smith (1993): its states are told apart
//! by their squares, so that their law often has two humps.
//!
//! The exact answer is computed here on a grid, by Bayes' rule and nothing else.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use crate::common::{GROWTH, noisy, residuals, run};
use fd_core::{Frame, stage::ResidualGenerator};
use fd_nonlinear::{
    Noise, NoisyModel, extended::ExtendedDesign, particle::ParticleDesign,
    unscented::UnscentedDesign,
};

const SAMPLES: usize = 50;
const SEEDS: u64 = 12;

/// Variances of 10 and 1, and a start near 0.1 with a variance of 2, as in the paper.
fn growth() -> NoisyModel {
    let noise =
        Noise { process: vec![10.0_f64.sqrt()], output: vec![1.0], initial: vec![2.0_f64.sqrt()] };
    noisy(GROWTH, noise)
}

/// The mean of the state after each sample, by Bayes' rule on a grid.
fn exact(y: &[Vec<f64>]) -> Vec<f64> {
    // As wide as the state ever is; the least width of a hump is 0.4, where |x| = 25.
    let grid: Vec<f64> = (-200..=200).map(|i| 0.2 * f64::from(i)).collect();
    let normal = |d: f64, variance: f64| (-0.5 * d * d / variance).exp();
    let mut p: Vec<f64> = grid.iter().map(|x| normal(x - 0.1, 2.0)).collect();
    let mut means = Vec::new();
    for (k, y) in (0..).zip(y) {
        for (p, x) in p.iter_mut().zip(&grid) {
            *p *= normal(y[0] - x * x / 20.0, 1.0);
        }
        let total: f64 = p.iter().sum();
        means.push(p.iter().zip(&grid).map(|(p, x)| p * x).sum::<f64>() / total);
        let drive = 8.0 * (1.2 * f64::from(k)).cos();
        let mut next = vec![0.0; grid.len()];
        for (p, x) in p.iter().zip(&grid).filter(|(p, _)| **p > 1e-12 * total) {
            let aim = 0.5 * x + 25.0 * x / (1.0 + x * x) + drive;
            for (next, to) in next.iter_mut().zip(&grid) {
                *next += p / total * normal(to - aim, 10.0);
            }
        }
        p = next;
    }
    means
}

/// States and outputs of each seed.
fn runs() -> Vec<[Vec<Vec<f64>>; 2]> {
    let u = vec![Vec::new(); SAMPLES];
    (0..SEEDS).map(|seed| run(&growth(), &u, 300 + seed).into()).collect()
}

/// Root mean square distances of the means of a particle filter to the exact ones.
fn distance(particles: usize) -> f64 {
    let mut all = Vec::new();
    for (seed, [_, y]) in (0..).zip(runs()) {
        let mut filter = ParticleDesign::new(growth(), particles, seed).unwrap().freeze();
        for (k, (y, exact)) in (0..).zip(y.iter().zip(exact(&y))) {
            let (mut r, mut mean) = ([0.0], [0.0]);
            filter.step(Frame::new(filter.io(), k, &[], y).unwrap(), &mut r);
            filter.mean(&mut mean);
            all.push(mean[0] - exact);
        }
    }
    fd_numeric::rms(all)
}

/// Twenty times the particles are √20 = 4.5 times nearer.
#[test]
fn particles_converge_to_bayes_rule() {
    let (few, many) = (distance(500), distance(10_000));
    // 600 distances each, of which a few, where a hump was lost, make up most: known to some 40 %.
    assert!(few / many > 2.7 && few / many < 7.5, "{few} {many}");
    assert!(many < 0.25, "of states up to 25: {many}");
}

/// Errors of the state: nothing beats Bayes' rule, many particles nearly reach it, slopes do not.
#[test]
fn slopes_lose_a_state_of_two_humps() {
    let mut squares = [const { Vec::new() }; 4];
    for (seed, [x, y]) in (0..).zip(runs()) {
        let mut extended = ExtendedDesign::new(growth()).freeze();
        let mut unscented = UnscentedDesign::new(growth(), None).unwrap().freeze();
        let mut particles = ParticleDesign::new(growth(), 500, seed).unwrap().freeze();
        for (k, ((y, x), exact)) in (0..).zip(y.iter().zip(&x).zip(exact(&y))) {
            let frame = Frame::new(extended.io(), k, &[], y).unwrap();
            let (mut r, mut mean) = ([0.0], [0.0]);
            extended.step(frame, &mut r);
            unscented.step(frame, &mut r);
            particles.step(frame, &mut r);
            particles.mean(&mut mean);
            let found = [exact, mean[0], unscented.state()[0], extended.state()[0]];
            found.iter().zip(&mut squares).for_each(|(found, all)| all.push(found - x[0]));
        }
    }
    let [bayes, particles, unscented, extended] =
        squares.map(|errors: Vec<f64>| fd_numeric::rms(errors));
    assert!(particles < 1.1 * bayes, "{particles} {bayes}");
    assert!(bayes < 0.8 * unscented, "{bayes} {unscented}");
    assert!(unscented < extended, "{unscented} {extended}");
}

/// The residual is the innovation: what the past says of `y`, subtracted.
#[test]
fn the_residual_is_what_is_new() {
    let (_, y) = run(&growth(), &vec![Vec::new(); 2000], 5);
    let mut filter = ParticleDesign::new(growth(), 300, 1).unwrap().freeze();
    let r = residuals(&mut filter, &vec![Vec::new(); 2000], &y);
    let mean = r.iter().map(|r| r[0]).sum::<f64>() / 2000.0;
    let spread = fd_numeric::rms(r.iter().map(|r| r[0]));
    // The mean of 2000 innovations, which are uncorrelated, within 3.3 of its standard deviations.
    assert!(mean.abs() < 3.3 * spread / 2000.0_f64.sqrt(), "{mean} {spread}");
    let size = fd_numeric::rms(y.iter().map(|y| y[0]));
    assert!(spread < 0.7 * size, "{spread} {size}");
}
