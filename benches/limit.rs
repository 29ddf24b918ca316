//! How many fused multiply-adds one core can do per second: what other figures are parts of.
#![expect(
    clippy::inline_always,
    reason = "what is not inlined into code for wide registers is compiled for narrow ones"
)]

use std::hint::black_box;

use fd_numeric::lanes::{LaneScalar, Machine, Registers, Simd, Work as OnRegisters};

/// Independent sums, enough to hide the latency of an addition.
const CHAINS: usize = 12;
/// Multiply-adds per sum.
const LENGTH: usize = 10_000;

struct Chains;

impl<T: LaneScalar> OnRegisters<T> for Chains {
    type Output = u64;

    #[inline(always)]
    fn run<S: Simd>(self, m: T::Registers<S>) -> u64 {
        let factor = m.splat(black_box(T::from_design(0.5)));
        let mut sums = [m.splat(black_box(T::one())); CHAINS];
        for _ in 0..LENGTH {
            for sum in &mut sums {
                *sum = m.mul_add(*sum, factor, factor);
            }
        }
        black_box(sums);
        (CHAINS * LENGTH * size_of_val(&factor) / size_of::<T>()) as u64
    }
}

/// A name and what does this many multiply-adds.
pub type Work = (&'static str, fn() -> u64);

/// Runs of multiply-adds, each of which returns how many numbers it has computed.
#[must_use]
pub fn fused_multiply_adds() -> [Work; 2] {
    [
        ("f64", || Machine::detect().run::<f64, _>(Chains)),
        ("f32", || Machine::detect().run::<f32, _>(Chains)),
    ]
}
