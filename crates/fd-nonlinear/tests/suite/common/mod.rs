//! Models, random numbers and runs that several tests need.
#![allow(dead_code, reason = "not every test needs all of it")]
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use fd_core::{Frame, stage::ResidualGenerator};
use fd_nonlinear::{Noise, NoisyModel, StateEquations};
use fd_sim::{model::Model, simulate::StateMap};
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_xoshiro::Xoshiro256PlusPlus;

/// Two states, two outputs, straight.
pub(crate) const STRAIGHT: &str = r#"
version = 1
kind = "equations"
name = "straight"
sample_time = 0.1
inputs = { u = { unit = "1" } }
[states]
a = { unit = "1", initial = 0.0, update = "0.9*a + 0.2*b + u" }
b = { unit = "1", initial = 0.0, update = "-0.1*a + 0.8*b + 0.5*u" }
[outputs]
y = { unit = "1", value = "a + 0.3*u" }
z = { unit = "1", value = "a - 2*b" }
"#;

/// Two tanks in a row; outflows go with the root of the level.
pub(crate) const TANKS: &str = r#"
version = 1
kind = "equations"
name = "tanks"
sample_time = 1.0
inputs = { q = { unit = "m^3/s" } }
[states]
h_1 = { unit = "m", initial = 1.0, derivative = "q - 0.1*sqrt(h_1)" }
h_2 = { unit = "m", initial = 1.0, derivative = "0.1*sqrt(h_1) - 0.1*sqrt(h_2)" }
[outputs]
level = { unit = "m", value = "h_2" }
"#;

/// The univariate non-stationary growth model (Gordon, Salmond and Smith 1993, section 4.1).
pub(crate) const GROWTH: &str = r#"
version = 1
kind = "equations"
name = "growth"
sample_time = 1.0
inputs = {}
states = { x = { unit = "1", initial = 0.1, update = "0.5*x + 25*x/(1 + x^2) + 8*cos(1.2*t)" } }
outputs = { y = { unit = "1", value = "x^2/20" } }
"#;

pub(crate) fn map(text: &str) -> StateMap {
    let model: Model = text.parse().unwrap();
    StateMap::new(&model, &model.nominal(), model.sample_time().unwrap()).unwrap()
}

pub(crate) fn noisy(text: &str, noise: Noise) -> NoisyModel {
    let map = map(text);
    let start = map.states().iter().map(|state| state.value).collect();
    NoisyModel::new(map, start, noise).unwrap()
}

pub(crate) fn random(seed: u64) -> Xoshiro256PlusPlus {
    Xoshiro256PlusPlus::seed_from_u64(seed)
}

pub(crate) fn normal(random: &mut Xoshiro256PlusPlus) -> f64 {
    random.sample(StandardNormal)
}

/// A run of the plant that a filter believes in: its states and outputs, with its noises.
pub(crate) fn run(model: &NoisyModel, u: &[Vec<f64>], seed: u64) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let (mut equations, mut random) = (model.equations(), random(seed));
    let noise = model.noise();
    let mut noisy = |values: &[f64], deviations: &[f64]| -> Vec<f64> {
        values.iter().zip(deviations).map(|(v, d)| v + d * normal(&mut random)).collect()
    };
    let mut x = noisy(model.start(), &noise.initial);
    let (mut states, mut outputs) = (Vec::new(), Vec::new());
    for (k, now) in u.iter().enumerate() {
        let mut y = vec![0.0; model.io().ny];
        equations.output(k as u64, &x, now, &mut y);
        outputs.push(noisy(&y, &noise.output));
        let mut next = x.clone();
        equations.advance(k as u64, &x, now, u.get(k + 1).unwrap_or(now), &mut next);
        states.push(std::mem::replace(&mut x, noisy(&next, &noise.process)));
    }
    (states, outputs)
}

/// The residuals of a run.
pub(crate) fn residuals(
    generator: &mut (impl ResidualGenerator + ?Sized),
    u: &[Vec<f64>],
    y: &[Vec<f64>],
) -> Vec<Vec<f64>> {
    let mut all = Vec::new();
    for (k, (u, y)) in (0..).zip(u.iter().zip(y)) {
        let mut r = vec![0.0; generator.residual_len()];
        generator.step(Frame::new(generator.io(), k, u, y).unwrap(), &mut r);
        all.push(r);
    }
    all
}
