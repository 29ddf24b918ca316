//! Random plants and signals shared by the tests.
#![allow(dead_code, reason = "each test file uses a part")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

pub(crate) mod cases;
pub(crate) mod changes;
pub(crate) mod design_cases;
pub(crate) mod problems;
pub(crate) mod transfer;

use faer::{Mat, Scale, c64};
use fd_core::{Frame, Scalar, stage::ResidualGenerator};
use fd_model::{Discrete, SampleTime, StateSpace};
use fd_numeric::dense::DenseReal;
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Sizes and seed of a random plant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Draw {
    pub(crate) nx: usize,
    pub(crate) nu: usize,
    pub(crate) ny: usize,
    pub(crate) radius: f64,
    pub(crate) seed: u64,
}

pub(crate) fn draws() -> impl Strategy<Value = Draw> {
    (1..=6_usize, 1..=3_usize, 1..=4_usize, 0.3..0.95_f64, any::<u64>())
        .prop_map(|(nx, nu, ny, radius, seed)| Draw { nx, nu, ny, radius, seed })
}

pub(crate) fn rng(seed: u64) -> Xoshiro256PlusPlus {
    Xoshiro256PlusPlus::seed_from_u64(seed)
}

/// Entries uniform in [-1, 1).
pub(crate) fn random_matrix(rng: &mut Xoshiro256PlusPlus, rows: usize, cols: usize) -> Mat<f64> {
    Mat::from_fn(rows, cols, |_, _| rng.random_range(-1.0..1.0))
}

pub(crate) fn sampled() -> Discrete {
    Discrete { ts: SampleTime::new(0.1).unwrap() }
}

/// A plant whose largest pole has the drawn modulus.
pub(crate) fn plant(draw: Draw) -> StateSpace<Discrete> {
    let mut rng = rng(draw.seed);
    let a = random_matrix(&mut rng, draw.nx, draw.nx);
    let radius = a.modes().unwrap().iter().map(|p: &c64| p.norm()).fold(1e-3, f64::max);
    let a = Scale(draw.radius / radius) * a;
    let b = random_matrix(&mut rng, draw.nx, draw.nu);
    let c = random_matrix(&mut rng, draw.ny, draw.nx);
    let d = random_matrix(&mut rng, draw.ny, draw.nu);
    StateSpace::new(a, b, c, d, sampled()).unwrap()
}

/// Samples of `width` channels, uniform in [-1, 1).
pub(crate) fn signal(seed: u64, width: usize, len: usize) -> Vec<Vec<f64>> {
    let mut rng = rng(seed);
    (0..len).map(|_| (0..width).map(|_| rng.random_range(-1.0..1.0)).collect()).collect()
}

/// Response of a model from the state `x0`.
pub(crate) fn simulate(model: &StateSpace<Discrete>, x0: &[f64], u: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut x = Mat::from_fn(model.nx(), 1, |i, _| x0[i]);
    let mut all = Vec::new();
    for u in u {
        let u = Mat::from_fn(model.nu(), 1, |i, _| u[i]);
        let y = model.c() * &x + model.d() * &u;
        all.push((0..model.ny()).map(|i| y[(i, 0)]).collect());
        x = model.a() * &x + model.b() * &u;
    }
    all
}

/// Residuals of a generator, one row per sample.
pub(crate) fn residuals<T: Scalar>(
    generator: &mut (impl ResidualGenerator<T> + ?Sized),
    u: &[Vec<T>],
    y: &[Vec<T>],
) -> Vec<Vec<T>> {
    let mut r = vec![T::zero(); generator.residual_len()];
    let mut all = Vec::new();
    for (k, (u, y)) in (0..).zip(u.iter().zip(y)) {
        generator.step(Frame::new(generator.io(), k, u, y).unwrap(), &mut r);
        all.push(r.clone());
    }
    all
}

/// Element-wise sum of two signals.
pub(crate) fn plus(a: &[Vec<f64>], b: &[Vec<f64>]) -> Vec<Vec<f64>> {
    a.iter().zip(b).map(|(a, b)| a.iter().zip(b).map(|(a, b)| a + b).collect()).collect()
}

/// `[u; y]` sample by sample.
pub(crate) fn joined(u: &[Vec<f64>], y: &[Vec<f64>]) -> Vec<Vec<f64>> {
    u.iter().zip(y).map(|(u, y)| u.iter().chain(y).copied().collect()).collect()
}

/// Largest difference of two signals.
pub(crate) fn distance(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Largest absolute value of a signal.
pub(crate) fn peak(a: &[Vec<f64>]) -> f64 {
    a.iter().flatten().map(|v| v.abs()).fold(0.0, f64::max)
}

/// Largest distance between two sets of poles, paired greedily.
pub(crate) fn pole_distance(found: &[c64], wanted: &[c64]) -> f64 {
    assert_eq!(found.len(), wanted.len());
    let mut left = found.to_vec();
    let mut worst = 0.0_f64;
    for w in wanted {
        let (i, d) = left
            .iter()
            .map(|f| (f - w).norm())
            .enumerate()
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap();
        left.swap_remove(i);
        worst = worst.max(d);
    }
    worst
}
