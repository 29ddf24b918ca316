//! Signals that several tests share.
#![allow(dead_code, reason = "each test uses its own part")]
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

pub(crate) mod long_run;

use fd_model::{Channel, Record, SampleTime};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// `len` numbers, uniform in -1 to 1.
pub(crate) fn noise(seed: u64, len: usize) -> Vec<f64> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    (0..len).map(|_| rng.random_range(-1.0..1.0)).collect()
}

/// The input of the measured wind-up cases: a constant and two sinusoids.
pub(crate) fn paper_like_input(k: u32) -> f64 {
    let k = f64::from(k);
    1.0 + 0.5 * (0.05 * k).sin() + 0.3 * (0.31 * k).sin()
}

/// A record of row-major samples.
pub(crate) fn record(nu: usize, ny: usize, u: Vec<f64>, y: Vec<f64>) -> Record {
    let (inputs, outputs) = (Channel::numbered("u", nu), Channel::numbered("mu", ny));
    Record::new(inputs, outputs, u, y, SampleTime::new(0.02).unwrap()).unwrap()
}

/// The bits of numbers, for claims of equality to the bit.
pub(crate) fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|v| v.to_bits()).collect()
}
