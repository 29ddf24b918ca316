//! Arithmetic on values, with the registers of the machine.
#![expect(
    clippy::inline_always,
    reason = "what is not inlined into code for wide registers is compiled for narrow ones"
)]

use std::marker::PhantomData;

use fd_core::Scalar;
use pulp::Simd;

use super::{
    evaluate,
    expr::{Binary, Comparison, Unary},
    value::{Lanes, Value},
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

/// Arithmetic in registers of several lanes.
#[derive(Clone, Copy)]
struct Registers<S>(S);

// Loops are written out: a closure handed to an iterator would be compiled for the smallest
// machine.
impl<S: Simd> Registers<S> {
    // `Simd::select_f64s` and `Simd::neg_f64s` are not inlined into code for wide registers.
    #[inline(always)]
    fn pick(self, mask: S::m64s, yes: S::f64s, no: S::f64s) -> S::f64s {
        pulp::cast(self.0.select_u64s(mask, pulp::cast(yes), pulp::cast(no)))
    }

    #[inline(always)]
    fn map<const N: usize>(to: &mut Lanes<N>, a: &Lanes<N>, f: impl Fn(S::f64s) -> S::f64s) {
        let (to, _) = S::as_mut_simd_f64s(&mut to.0);
        let (a, _) = S::as_simd_f64s(&a.0);
        for i in 0..N / S::F64_LANES {
            to[i] = f(a[i]);
        }
    }

    #[inline(always)]
    fn zip<const N: usize>(
        to: &mut Lanes<N>,
        a: &Lanes<N>,
        b: &Lanes<N>,
        f: impl Fn(S::f64s, S::f64s) -> S::f64s,
    ) {
        let (to, _) = S::as_mut_simd_f64s(&mut to.0);
        let ((a, _), (b, _)) = (S::as_simd_f64s(&a.0), S::as_simd_f64s(&b.0));
        for i in 0..N / S::F64_LANES {
            to[i] = f(a[i], b[i]);
        }
    }

    #[inline(always)]
    fn zip3<const N: usize>(
        to: &mut Lanes<N>,
        [a, b, c]: [&Lanes<N>; 3],
        f: impl Fn(S::f64s, S::f64s, S::f64s) -> S::f64s,
    ) {
        let (to, _) = S::as_mut_simd_f64s(&mut to.0);
        let ((a, _), (b, _)) = (S::as_simd_f64s(&a.0), S::as_simd_f64s(&b.0));
        let (c, _) = S::as_simd_f64s(&c.0);
        for i in 0..N / S::F64_LANES {
            to[i] = f(a[i], b[i], c[i]);
        }
    }
}

impl<S: Simd, const N: usize> Kernel<Lanes<N>> for Registers<S> {
    #[inline(always)]
    fn add(self, to: &mut Lanes<N>, a: &Lanes<N>, b: &Lanes<N>) {
        let simd = self.0;
        Self::zip(
            to,
            a,
            b,
            #[inline(always)]
            |a, b| simd.add_f64s(a, b),
        );
    }

    #[inline(always)]
    fn sub(self, to: &mut Lanes<N>, a: &Lanes<N>, b: &Lanes<N>) {
        let simd = self.0;
        Self::zip(
            to,
            a,
            b,
            #[inline(always)]
            |a, b| simd.sub_f64s(a, b),
        );
    }

    #[inline(always)]
    fn mul(self, to: &mut Lanes<N>, a: &Lanes<N>, b: &Lanes<N>) {
        let simd = self.0;
        Self::zip(
            to,
            a,
            b,
            #[inline(always)]
            |a, b| simd.mul_f64s(a, b),
        );
    }

    #[inline(always)]
    fn div(self, to: &mut Lanes<N>, a: &Lanes<N>, b: &Lanes<N>) {
        let simd = self.0;
        Self::zip(
            to,
            a,
            b,
            #[inline(always)]
            |a, b| simd.div_f64s(a, b),
        );
    }

    #[inline(always)]
    fn mul_add(self, to: &mut Lanes<N>, a: &Lanes<N>, b: &Lanes<N>, c: &Lanes<N>) {
        let simd = self.0;
        Self::zip3(
            to,
            [a, b, c],
            #[inline(always)]
            |a, b, c| simd.add_f64s(simd.mul_f64s(a, b), c),
        );
    }

    #[inline(always)]
    fn mul_sub(self, to: &mut Lanes<N>, a: &Lanes<N>, b: &Lanes<N>, c: &Lanes<N>) {
        let simd = self.0;
        Self::zip3(
            to,
            [a, b, c],
            #[inline(always)]
            |a, b, c| simd.sub_f64s(simd.mul_f64s(a, b), c),
        );
    }

    #[inline(always)]
    fn sub_mul(self, to: &mut Lanes<N>, a: &Lanes<N>, b: &Lanes<N>, c: &Lanes<N>) {
        let simd = self.0;
        Self::zip3(
            to,
            [a, b, c],
            #[inline(always)]
            |a, b, c| simd.sub_f64s(c, simd.mul_f64s(a, b)),
        );
    }

    #[inline(always)]
    fn neg(self, to: &mut Lanes<N>, a: &Lanes<N>) {
        let simd = self.0;
        let minus = simd.splat_f64s(-1.0);
        Self::map(
            to,
            a,
            #[inline(always)]
            |a| simd.mul_f64s(a, minus),
        );
    }

    #[inline(always)]
    fn sqrt(self, to: &mut Lanes<N>, a: &Lanes<N>) {
        let simd = self.0;
        Self::map(
            to,
            a,
            #[inline(always)]
            |a| simd.sqrt_f64s(a),
        );
    }

    #[inline(always)]
    fn smaller(self, to: &mut Lanes<N>, a: &Lanes<N>, b: &Lanes<N>) {
        let simd = self.0;
        Self::zip(
            to,
            a,
            b,
            #[inline(always)]
            |a, b| self.pick(simd.less_than_f64s(b, a), b, a),
        );
    }

    #[inline(always)]
    fn larger(self, to: &mut Lanes<N>, a: &Lanes<N>, b: &Lanes<N>) {
        let simd = self.0;
        Self::zip(
            to,
            a,
            b,
            #[inline(always)]
            |a, b| self.pick(simd.less_than_f64s(a, b), b, a),
        );
    }

    #[inline(always)]
    fn clamp(self, to: &mut Lanes<N>, a: &Lanes<N>, b: &Lanes<N>, c: &Lanes<N>) {
        let simd = self.0;
        Self::zip3(
            to,
            [a, b, c],
            #[inline(always)]
            |a, b, c| {
                let above = self.pick(simd.less_than_f64s(a, b), b, a);
                self.pick(simd.less_than_f64s(c, above), c, above)
            },
        );
    }

    #[inline(always)]
    fn compare(self, comparison: Comparison, to: &mut Lanes<N>, a: &Lanes<N>, b: &Lanes<N>) {
        let simd = self.0;
        let (yes, no) = (simd.splat_f64s(1.0), simd.splat_f64s(0.0));
        macro_rules! holds {
            ($method:ident, $a:expr, $b:expr) => {
                Self::zip(
                    to,
                    $a,
                    $b,
                    #[inline(always)]
                    |a, b| self.pick(simd.$method(a, b), yes, no),
                )
            };
        }
        match comparison {
            Comparison::Less => holds!(less_than_f64s, a, b),
            Comparison::LessEqual => holds!(less_than_or_equal_f64s, a, b),
            Comparison::Greater => holds!(less_than_f64s, b, a),
            Comparison::GreaterEqual => holds!(less_than_or_equal_f64s, b, a),
            Comparison::Equal => holds!(equal_f64s, a, b),
        }
    }

    #[inline(always)]
    fn select(self, to: &mut Lanes<N>, a: &Lanes<N>, b: &Lanes<N>, c: &Lanes<N>) {
        let simd = self.0;
        let zero = simd.splat_f64s(0.0);
        Self::zip3(
            to,
            [a, b, c],
            #[inline(always)]
            |a, b, c| self.pick(simd.less_than_f64s(zero, a), b, c),
        );
    }
}

/// Work on lanes, waiting for a machine.
pub(super) struct InLanes<W, V> {
    pub(super) work: W,
    pub(super) lanes: PhantomData<V>,
}

impl<const N: usize, W: Work<Lanes<N>>> pulp::WithSimd for InLanes<W, Lanes<N>> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.work.run(Registers(simd));
    }
}
