//! Several numbers as a value.
#![expect(
    clippy::inline_always,
    reason = "what is not inlined into code for wide registers is compiled for narrow ones"
)]

use std::marker::PhantomData;

use fd_numeric::lanes::Machine;

use super::{
    registers::InLanes,
    value::{Lanes, Value, Work},
};

impl<const N: usize> Value for Lanes<N> {
    type Lane = f64;

    const LANES: usize = N;

    #[inline(always)]
    fn splat(lane: f64) -> Self {
        Self([lane; N])
    }

    #[inline(always)]
    fn lane(&self, lane: usize) -> f64 {
        self.0[lane]
    }

    #[inline(always)]
    fn set_lane(&mut self, lane: usize, value: f64) {
        self.0[lane] = value;
    }

    #[inline(always)]
    fn map(mut self, f: impl Fn(f64) -> f64) -> Self {
        for i in 0..N {
            self.0[i] = f(self.0[i]);
        }
        self
    }

    #[inline(always)]
    fn zip(mut self, b: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        for i in 0..N {
            self.0[i] = f(self.0[i], b.0[i]);
        }
        self
    }

    #[inline(always)]
    fn zip3(mut self, b: Self, c: Self, f: impl Fn(f64, f64, f64) -> f64) -> Self {
        for i in 0..N {
            self.0[i] = f(self.0[i], b.0[i], c.0[i]);
        }
        self
    }

    #[inline(always)]
    fn all_finite(&self) -> bool {
        let mut all = true;
        for value in self.0 {
            all &= value.is_finite();
        }
        all
    }

    fn vectorized<W: Work<Self>>(work: W) {
        Machine::detect().for_rows_of(N).run(InLanes { work, lanes: PhantomData::<Self> });
    }
}
