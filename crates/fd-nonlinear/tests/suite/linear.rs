//! On a linear model a nonlinear filter is the Kalman filter.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use crate::common::{STRAIGHT, noisy, normal, random, residuals, run};
use faer::{Mat, mat, prelude::Solve};
use fd_nonlinear::{
    Noise, extended::ExtendedDesign, particle::ParticleDesign, unscented::UnscentedDesign,
};
use fd_numeric::dense::Dense;

fn noise() -> Noise {
    Noise { process: vec![0.05, 0.02], output: vec![0.1, 0.3], initial: vec![1.0, 0.5] }
}

fn inputs(samples: usize) -> Vec<Vec<f64>> {
    let mut random = random(41);
    (0..samples).map(|_| vec![normal(&mut random)]).collect()
}

/// The Kalman filter with full covariances (Kalman 1960), written out as in any textbook.
fn kalman(u: &[Vec<f64>], y: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let (a, b) = (mat![[0.9, 0.2], [-0.1, 0.8]], mat![[1.0], [0.5]]);
    let (c, d) = (mat![[1.0, 0.0], [1.0, -2.0]], mat![[0.3], [0.0]]);
    let square =
        |v: &[f64]| Mat::from_fn(v.len(), v.len(), |i, j| if i == j { v[i] * v[i] } else { 0.0 });
    let column = |v: &[f64]| Mat::from_fn(v.len(), 1, |i, _| v[i]);
    let Noise { process, output, initial } = noise();
    let (q, r) = (square(&process), square(&output));
    let (mut x, mut p) = (Mat::<f64>::zeros(2, 1), square(&initial));
    let mut all = Vec::new();
    for (u, y) in u.iter().zip(y) {
        let e = column(y) - &c * &x - &d * column(u);
        all.push((0..2).map(|i| e[(i, 0)]).collect());
        let s = &c * &p * c.transpose() + &r;
        let gain = s.lu().solve(&c * &p).transpose().to_owned();
        x += &gain * &e;
        p = &p - &gain * &c * &p;
        x = &a * &x + &b * column(u);
        p = &a * &p * a.transpose() + &q;
    }
    all
}

fn largest_difference(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn extended_and_unscented_are_the_kalman_filter() {
    let model = noisy(STRAIGHT, noise());
    let u = inputs(500);
    let (_, y) = run(&model, &u, 1);
    let expected = kalman(&u, &y);
    let size = expected.iter().flatten().fold(0.0, |m: f64, v| m.max(v.abs()));
    assert!(size > 0.3, "the innovations are of size one, {size}");
    // A central difference of a straight line errs by rounding alone: 1e-16 over steps of 6e-6 of the
    // state, and gains of order one multiply states of up to 20: some 1e-9.
    let mut extended = ExtendedDesign::new(model.clone()).freeze();
    let left = largest_difference(&residuals(&mut extended, &u, &y), &expected);
    assert!(left < 1e-8, "extended: {left}");
    // Slopes that stay what they are may be renewed one by one.
    let mut in_turns = ExtendedDesign::new(model.clone()).linearised_over(7).freeze();
    let left = largest_difference(&residuals(&mut in_turns, &u, &y), &expected);
    assert!(left < 1e-8, "extended, in turns: {left}");
    // Points have no steps: roundings of numbers of size 20, over some tens of samples of memory.
    for kappa in [None, Some(0.0), Some(3.0)] {
        let mut unscented = UnscentedDesign::new(model.clone(), kappa).unwrap().freeze();
        let left = largest_difference(&residuals(&mut unscented, &u, &y), &expected);
        assert!(left < 1e-12, "unscented, {kappa:?}: {left}");
    }
}

/// Root mean square of the difference to the Kalman filter, over all samples, for one seed.
fn error_of(particles: usize, seed: u64) -> f64 {
    let model = noisy(STRAIGHT, noise());
    let u = inputs(60);
    let (_, y) = run(&model, &u, 100 + seed);
    let expected = kalman(&u, &y);
    let mut filter = ParticleDesign::new(model, particles, seed).unwrap().freeze();
    let found = residuals(&mut filter, &u, &y);
    let pairs = found.iter().flatten().zip(expected.iter().flatten());
    fd_numeric::rms(pairs.map(|(a, b)| a - b))
}

/// The error of a particle filter falls with the root of the number of particles, to zero.
#[test]
fn particles_converge_to_the_kalman_filter() {
    let mean_log = |particles: usize| -> (f64, f64) {
        let logs: Vec<f64> = (0..20).map(|seed| error_of(particles, seed).ln()).collect();
        let mean = logs.iter().sum::<f64>() / 20.0;
        let variance = logs.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / 19.0;
        (mean, variance / 20.0)
    };
    let (few, many) = (mean_log(50), mean_log(3200));
    let order = (few.0 - many.0) / 64.0_f64.ln();
    let half_width = 2.6 * (few.1 + many.1).sqrt() / 64.0_f64.ln();
    // 99 % interval around the order 1/2 of a mean of independent draws; fifty particles are few enough
    // to be a little worse than that.
    assert!((order - 0.5).abs() < half_width + 0.1, "{order} ± {half_width}");
    assert!(half_width < 0.1 && many.0.exp() < 0.02, "{half_width} {}", many.0.exp());
}
