//! How many fused multiply-adds one core can do per second: what other figures are parts of.

use std::hint::black_box;

use pulp::{Arch, Simd, WithSimd};

/// Independent sums, enough to hide the latency of an addition.
const CHAINS: usize = 12;
/// Multiply-adds per sum.
const LENGTH: usize = 10_000;

macro_rules! chains {
    ($name:ident, $lanes:ident, $splat:ident, $mul_add:ident) => {
        struct $name;

        impl WithSimd for $name {
            type Output = u64;

            #[inline(always)]
            fn with_simd<S: Simd>(self, simd: S) -> u64 {
                let factor = simd.$splat(black_box(0.5));
                let mut sums = [simd.$splat(black_box(1.0)); CHAINS];
                for _ in 0..LENGTH {
                    for sum in &mut sums {
                        *sum = simd.$mul_add(*sum, factor, factor);
                    }
                }
                black_box(sums);
                (CHAINS * LENGTH * S::$lanes) as u64
            }
        }
    };
}

chains!(Doubles, F64_LANES, splat_f64s, mul_add_e_f64s);
chains!(Singles, F32_LANES, splat_f32s, mul_add_e_f32s);

/// A name and what does this many multiply-adds.
pub type Work = (&'static str, fn() -> u64);

/// Runs of multiply-adds, each of which returns how many numbers it has computed.
#[must_use]
pub fn fused_multiply_adds() -> [Work; 2] {
    [("f64", || Arch::new().dispatch(Doubles)), ("f32", || Arch::new().dispatch(Singles))]
}
