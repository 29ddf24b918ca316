//! Random models and ways of comparing matrices.

use faer::{Mat, MatRef, Scale, c64};
use fd_model::{Continuous, Discrete, SampleTime, StateSpace};
use fd_numeric::dense::{Dense, DenseReal};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Sizes and a seed, from which a model is made.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Recipe {
    pub(crate) nx: usize,
    pub(crate) nu: usize,
    pub(crate) ny: usize,
    pub(crate) seed: u64,
}

/// Recipes with up to `nx` states and three inputs and outputs.
pub(crate) fn recipes(nx: usize) -> impl proptest::strategy::Strategy<Value = Recipe> {
    use proptest::prelude::*;
    (1..=nx, 1..=3_usize, 1..=3_usize, any::<u64>()).prop_map(|(nx, nu, ny, seed)| Recipe {
        nx,
        nu,
        ny,
        seed,
    })
}

pub(crate) fn random(rows: usize, cols: usize, rng: &mut Xoshiro256PlusPlus) -> Mat<f64> {
    Mat::from_fn(rows, cols, |_, _| rng.random_range(-1.0..1.0))
}

pub(crate) fn rng(seed: u64) -> Xoshiro256PlusPlus {
    Xoshiro256PlusPlus::seed_from_u64(seed)
}

/// A stable continuous model with its slowest mode at `−0.1` or faster.
pub(crate) fn continuous(recipe: Recipe) -> StateSpace<Continuous> {
    let Recipe { nx, nu, ny, seed } = recipe;
    let mut rng = rng(seed);
    let a = random(nx, nx, &mut rng);
    let abscissa = a.modes().unwrap().iter().fold(f64::NEG_INFINITY, |m, p| m.max(p.re));
    let a = a - Scale(abscissa + 0.1) * Mat::<f64>::identity(nx, nx);
    let (b, c) = (random(nx, nu, &mut rng), random(ny, nx, &mut rng));
    let d = random(ny, nu, &mut rng);
    StateSpace::new(a, b, c, d, Continuous).unwrap()
}

/// A stable discrete model with spectral radius 0.9, sampled every 0.1 s.
pub(crate) fn discrete(recipe: Recipe) -> StateSpace<Discrete> {
    let Recipe { nx, nu, ny, seed } = recipe;
    let mut rng = rng(seed);
    let a = random(nx, nx, &mut rng);
    let radius = a.modes().unwrap().iter().fold(0.0_f64, |m, p| m.max(p.norm()));
    let a = Scale(0.9 / radius) * a;
    let (b, c) = (random(nx, nu, &mut rng), random(ny, nx, &mut rng));
    let d = random(ny, nu, &mut rng);
    StateSpace::new(a, b, c, d, Discrete { ts: ts(0.1) }).unwrap()
}

pub(crate) fn ts(seconds: f64) -> SampleTime {
    SampleTime::new(seconds).unwrap()
}

/// `‖X − Y‖ / max(‖X‖, ‖Y‖)`, in Frobenius norms.
pub(crate) fn distance(x: MatRef<'_, f64>, y: MatRef<'_, f64>) -> f64 {
    let scale = x.norm_l2().max(y.norm_l2());
    if scale > 0.0 { (x - y).norm_l2() / scale } else { 0.0 }
}

/// `‖X − Y‖ / max(‖X‖, ‖Y‖)` of complex matrices.
pub(crate) fn distance_c(x: MatRef<'_, c64>, y: MatRef<'_, c64>) -> f64 {
    (x - y).norm_l2() / x.norm_l2().max(y.norm_l2()).max(f64::MIN_POSITIVE)
}

/// Largest singular value of a complex matrix.
pub(crate) fn sigma(x: MatRef<'_, c64>) -> f64 {
    x.sigmas().unwrap().first().copied().unwrap_or(0.0)
}
