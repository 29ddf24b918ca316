//! Arithmetic on values: what a program needs of a machine, and that of one number.
#![expect(
    clippy::inline_always,
    reason = "what is not inlined into code for wide registers is compiled for narrow ones"
)]

use fd_core::Scalar;

use super::{
    evaluate,
    expr::{Binary, Comparison, Unary},
    value::Value,
};

/// The cheap operations on values, written to `to`. Each lane gets to the bit what `evaluate` says.
pub trait Kernel<V: Value>: Copy {
    /// `a + b`.
    fn add(self, to: &mut V, a: &V, b: &V);
    /// `a - b`.
    fn sub(self, to: &mut V, a: &V, b: &V);
    /// `a*b`.
    fn mul(self, to: &mut V, a: &V, b: &V);
    /// `a/b`.
    fn div(self, to: &mut V, a: &V, b: &V);
    /// `a*b + c`, with the product rounded.
    fn mul_add(self, to: &mut V, a: &V, b: &V, c: &V);
    /// `a*b - c`, with the product rounded.
    fn mul_sub(self, to: &mut V, a: &V, b: &V, c: &V);
    /// `c - a*b`, with the product rounded.
    fn sub_mul(self, to: &mut V, a: &V, b: &V, c: &V);
    /// `-a`.
    fn neg(self, to: &mut V, a: &V);
    /// `sqrt(a)`.
    fn sqrt(self, to: &mut V, a: &V);
    /// `sin(a)`.
    fn sin(self, to: &mut V, a: &V);
    /// `cos(a)`.
    fn cos(self, to: &mut V, a: &V);
    /// `exp(a)`.
    fn exp(self, to: &mut V, a: &V);
    /// `tanh(a)`.
    fn tanh(self, to: &mut V, a: &V);
    /// `b` where `b < a`, else `a`.
    fn smaller(self, to: &mut V, a: &V, b: &V);
    /// `b` where `a < b`, else `a`.
    fn larger(self, to: &mut V, a: &V, b: &V);
    /// `a` within `b` and `c`.
    fn clamp(self, to: &mut V, a: &V, b: &V, c: &V);
    /// 1 where the comparison holds, else 0.
    fn compare(self, comparison: Comparison, to: &mut V, a: &V, b: &V);
    /// `b` where `0 < a`, else `c`.
    fn select(self, to: &mut V, a: &V, b: &V, c: &V);
}

/// Something to be computed with a kernel.
pub trait Work<V: Value> {
    /// Computes it.
    fn run(self, kernel: impl Kernel<V>);
}

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
