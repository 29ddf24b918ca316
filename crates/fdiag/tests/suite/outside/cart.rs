//! A cart on a spring as a simulator outside of this program, with noise of its own if that is wanted, and logs of the
//! real one.

use std::{
    fmt::Write,
    path::PathBuf,
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering::Relaxed},
    },
};

use fd_sim::outside::{
    Contract, Entry, Instance, Lost, OutsideError, OutsideSimulator, Powers, Source, Start, Stated,
};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use tempfile::TempDir;

pub(crate) const TS: f64 = 0.02;
/// Noise of place and speed in the logs.
pub(crate) const NOISE: [f64; 2] = [0.002, 0.01];
/// Mass, damping and stiffness.
const THETA: [f64; 3] = [1.2, 1.5, 4.0];
/// Speed below which dry friction is smooth.
const CREEP: f64 = 0.02;

/// What is random in the simulator, or in reality.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Chance {
    /// Standard deviation of what is added to place and speed in each sample.
    pub(crate) of_sensors: [f64; 2],
    /// Standard deviation of a force that is another one in each step.
    pub(crate) gust: f64,
}

/// What the real cart has that the simulator has not.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Cause {
    Nothing,
    Coulomb(f64),
    /// In samples.
    Delay(usize),
    SpeedScale(f64),
}

/// One cart.
#[derive(Debug)]
struct Cart {
    theta: [f64; 3],
    x: [f64; 2],
    friction: f64,
    chance: Chance,
    seeds: Arc<AtomicU64>,
    draws: Xoshiro256PlusPlus,
}

impl Cart {
    fn new(chance: Chance, seeds: &Arc<AtomicU64>) -> Self {
        let draws = Xoshiro256PlusPlus::seed_from_u64(0);
        Self { theta: THETA, x: [0.0; 2], friction: 0.0, chance, seeds: Arc::clone(seeds), draws }
    }

    /// By Runge-Kutta of order 4.
    fn moved(&self, force: f64) -> [f64; 2] {
        let [m, d, k] = self.theta;
        let slope = |[q, v]: [f64; 2]| {
            let dry = self.friction * (v / CREEP).tanh();
            [v, (force - dry - d * v - k * q) / m]
        };
        let on = |x: [f64; 2], by: f64, s: [f64; 2]| [x[0] + by * s[0], x[1] + by * s[1]];
        let x = self.x;
        let a = slope(x);
        let b = slope(on(x, 0.5 * TS, a));
        let c = slope(on(x, 0.5 * TS, b));
        let d = slope(on(x, TS, c));
        let sum = [0, 1].map(|i| a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]);
        on(x, TS / 6.0, sum)
    }

    fn normal(&mut self, deviation: f64) -> f64 {
        if deviation == 0.0 {
            return 0.0;
        }
        // Box and Muller, one of the two.
        let [a, b]: [f64; 2] = [self.draws.random(), self.draws.random()];
        deviation * (-2.0 * (1.0 - a).ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    }
}

impl Instance for Cart {
    fn reset(&mut self, start: Start<'_>) -> Result<(), Lost> {
        self.theta.copy_from_slice(start.theta);
        self.x.copy_from_slice(start.x0);
        // Each run has draws of its own.
        self.draws = Xoshiro256PlusPlus::seed_from_u64(self.seeds.fetch_add(1, Relaxed));
        Ok(())
    }

    fn measure(&mut self, _: &[f64], _: &mut [f64]) -> Result<(), Lost> {
        Err(Lost::Refused)
    }

    fn step(&mut self, row: &[f64], y: &mut [f64], x: &mut [f64]) -> Result<(), Lost> {
        let [of_place, of_speed] = self.chance.of_sensors;
        y.copy_from_slice(&[self.x[0] + self.normal(of_place), self.x[1] + self.normal(of_speed)]);
        let gust = self.normal(self.chance.gust);
        self.x = self.moved(row[0] + row[1] + gust);
        x.copy_from_slice(&self.x);
        Ok(())
    }
}

/// Makes carts.
#[derive(Debug)]
struct Carts(Chance, Arc<AtomicU64>);

impl Source for Carts {
    fn open(&self) -> Result<Box<dyn Instance>, OutsideError> {
        Ok(Box::new(Cart::new(self.0, &self.1)))
    }
}

/// The simulator, of which the noise is stated or not.
pub(crate) fn simulator(chance: Chance, seed: u64, is_stated: bool) -> OutsideSimulator {
    let entry = |name: &str, unit: &str| Entry {
        name: name.to_owned(),
        unit: Some(unit.to_owned()),
        ..Entry::default()
    };
    let parameter = |(name, unit, value, tolerance): (&str, &str, f64, f64)| Entry {
        value: Some(value),
        tolerance: Some(tolerance),
        ..entry(name, unit)
    };
    let output = |name: &str, unit: &str, noise: f64| Entry {
        noise: is_stated.then_some(noise),
        ..entry(name, unit)
    };
    let stated = Stated {
        name: Some("cart".to_owned()),
        sample_time: Some(TS),
        inputs: vec![entry("force", "N")],
        outputs: vec![output("place", "m", NOISE[0]), output("speed", "m/s", NOISE[1])],
        parameters: [
            ("m", "kg", THETA[0], 0.03),
            ("d", "N s/m", THETA[1], 0.1),
            ("k", "N/m", THETA[2], 0.03),
        ]
        .map(parameter)
        .to_vec(),
        states: vec![entry("q", "m"), entry("v", "m/s")],
        ports: vec![Entry {
            position: Some("place".to_owned()),
            velocity: Some("speed".to_owned()),
            ..entry("rail", "N")
        }],
        powers: Some(Powers { states: true, ..Powers::default() }),
        ..Stated::default()
    };
    let contract: Contract = stated.contract("cart").unwrap();
    // Seeds of runs are far from those of logs.
    let seeds = Arc::new(AtomicU64::new(1_000_000 * (1 + seed)));
    OutsideSimulator::new(contract, Carts(chance, seeds), 1).unwrap()
}

/// A log of the real cart, driven by steps of random height.
pub(crate) fn log(to: &TempDir, cause: Cause, samples: usize, seed: u64) -> PathBuf {
    let mut cart = Cart::new(Chance::default(), &Arc::default());
    cart.theta = [1.01 * THETA[0], 0.96 * THETA[1], 1.01 * THETA[2]];
    let mut draws = Xoshiro256PlusPlus::seed_from_u64(seed);
    cart.draws = Xoshiro256PlusPlus::seed_from_u64(draws.random());
    let (mut force, mut until) = (0.0, 0);
    let mut forces = Vec::new();
    let mut text = String::from("time [s],force [N],place [m],speed [m/s]\n");
    let (mut delay, mut scale) = (0, 1.0);
    match cause {
        Cause::Nothing => {}
        Cause::Coulomb(friction) => cart.friction = friction,
        Cause::Delay(samples) => delay = samples,
        Cause::SpeedScale(error) => scale += error,
    }
    for k in 0..samples {
        if until <= k {
            force = draws.random_range(-3.0..3.0);
            until = k + draws.random_range(20..70);
        }
        forces.push(force);
        let [place, speed] = cart.x;
        let noise = NOISE.map(|deviation| cart.normal(deviation));
        let measured = [place + noise[0], scale * speed + noise[1]];
        let t = TS * k as f64;
        writeln!(text, "{t},{force},{},{}", measured[0], measured[1]).unwrap();
        let arrives = k.checked_sub(delay).map_or(0.0, |k| forces[k]);
        cart.x = cart.moved(arrives);
    }
    let path = to.path().join(format!("log-{seed}.csv"));
    std::fs::write(&path, text).unwrap();
    path
}
