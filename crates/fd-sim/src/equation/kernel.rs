//! Arithmetic of one number.
#![expect(
    clippy::inline_always,
    reason = "what is not inlined into code for wide registers is compiled for narrow ones"
)]

use fd_core::Scalar;

use super::{
    evaluate,
    expr::{Binary, Comparison, Unary},
    value::{Kernel, Value, Work},
};

/// Arithmetic of a scalar.
#[derive(Clone, Copy)]
pub(super) struct OneLane;

impl<T: Scalar> Kernel<T> for OneLane {
    #[inline(always)]
    fn add(self, to: &mut T, a: &T, b: &T) {
        *to = *a + *b;
    }

    #[inline(always)]
    fn sub(self, to: &mut T, a: &T, b: &T) {
        *to = *a - *b;
    }

    #[inline(always)]
    fn mul(self, to: &mut T, a: &T, b: &T) {
        *to = *a * *b;
    }

    #[inline(always)]
    fn div(self, to: &mut T, a: &T, b: &T) {
        *to = *a / *b;
    }

    #[inline(always)]
    fn mul_add(self, to: &mut T, a: &T, b: &T, c: &T) {
        *to = *a * *b + *c;
    }

    #[inline(always)]
    fn mul_sub(self, to: &mut T, a: &T, b: &T, c: &T) {
        *to = *a * *b - *c;
    }

    #[inline(always)]
    fn sub_mul(self, to: &mut T, a: &T, b: &T, c: &T) {
        *to = *c - *a * *b;
    }

    #[inline(always)]
    fn neg(self, to: &mut T, a: &T) {
        *to = -*a;
    }

    #[inline(always)]
    fn sqrt(self, to: &mut T, a: &T) {
        *to = evaluate::unary(Unary::Sqrt, *a);
    }

    #[inline(always)]
    fn sin(self, to: &mut T, a: &T) {
        *to = evaluate::unary(Unary::Sin, *a);
    }

    #[inline(always)]
    fn cos(self, to: &mut T, a: &T) {
        *to = evaluate::unary(Unary::Cos, *a);
    }

    #[inline(always)]
    fn exp(self, to: &mut T, a: &T) {
        *to = evaluate::unary(Unary::Exp, *a);
    }

    #[inline(always)]
    fn tanh(self, to: &mut T, a: &T) {
        *to = evaluate::unary(Unary::Tanh, *a);
    }

    #[inline(always)]
    fn smaller(self, to: &mut T, a: &T, b: &T) {
        *to = evaluate::binary(Binary::Min, *a, *b);
    }

    #[inline(always)]
    fn larger(self, to: &mut T, a: &T, b: &T) {
        *to = evaluate::binary(Binary::Max, *a, *b);
    }

    #[inline(always)]
    fn clamp(self, to: &mut T, a: &T, b: &T, c: &T) {
        *to = evaluate::clamp(*a, *b, *c);
    }

    #[inline(always)]
    fn compare(self, comparison: Comparison, to: &mut T, a: &T, b: &T) {
        *to = if evaluate::compare(comparison, *a, *b) { T::one() } else { T::zero() };
    }

    #[inline(always)]
    fn select(self, to: &mut T, a: &T, b: &T, c: &T) {
        *to = if T::zero() < *a { *b } else { *c };
    }
}

impl<T: Scalar> Value for T {
    type Lane = T;

    const LANES: usize = 1;

    #[inline(always)]
    fn splat(lane: T) -> Self {
        lane
    }

    #[inline(always)]
    fn lane(&self, _lane: usize) -> T {
        *self
    }

    #[inline(always)]
    fn set_lane(&mut self, _lane: usize, value: T) {
        *self = value;
    }

    #[inline(always)]
    fn map(self, f: impl Fn(T) -> T) -> Self {
        f(self)
    }

    #[inline(always)]
    fn zip(self, b: Self, f: impl Fn(T, T) -> T) -> Self {
        f(self, b)
    }

    #[inline(always)]
    fn zip3(self, b: Self, c: Self, f: impl Fn(T, T, T) -> T) -> Self {
        f(self, b, c)
    }

    #[inline(always)]
    fn all_finite(&self) -> bool {
        self.is_finite()
    }

    #[inline(always)]
    fn vectorized<W: Work<Self>>(work: W) {
        work.run(OneLane);
    }
}
