//! Arithmetic on values, with the registers of the machine.

use std::marker::PhantomData;

use fd_core::Scalar;
use pulp::Simd;

use super::{
    evaluate,
    expr::{Binary, Comparison, Unary},
    value::{Lanes, Value},
};

/// The cheap operations on values. Each lane gets to the bit what [`evaluate`] says.
pub trait Kernel<V: Value>: Copy {
    /// `a + b`.
    fn add(self, a: V, b: V) -> V;
    /// `a - b`.
    fn sub(self, a: V, b: V) -> V;
    /// `a*b`.
    fn mul(self, a: V, b: V) -> V;
    /// `a/b`.
    fn div(self, a: V, b: V) -> V;
    /// `-a`.
    fn neg(self, a: V) -> V;
    /// `sqrt(a)`.
    fn sqrt(self, a: V) -> V;
    /// `b` where `b < a`, else `a`.
    fn smaller(self, a: V, b: V) -> V;
    /// `b` where `a < b`, else `a`.
    fn larger(self, a: V, b: V) -> V;
    /// 1 where the comparison holds, else 0.
    fn compare(self, comparison: Comparison, a: V, b: V) -> V;
    /// `b` where `0 < a`, else `c`.
    fn select(self, a: V, b: V, c: V) -> V;
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
    fn add(self, a: T, b: T) -> T {
        a + b
    }

    #[inline(always)]
    fn sub(self, a: T, b: T) -> T {
        a - b
    }

    #[inline(always)]
    fn mul(self, a: T, b: T) -> T {
        a * b
    }

    #[inline(always)]
    fn div(self, a: T, b: T) -> T {
        a / b
    }

    #[inline(always)]
    fn neg(self, a: T) -> T {
        -a
    }

    #[inline(always)]
    fn sqrt(self, a: T) -> T {
        evaluate::unary(Unary::Sqrt, a)
    }

    #[inline(always)]
    fn smaller(self, a: T, b: T) -> T {
        evaluate::binary(Binary::Min, a, b)
    }

    #[inline(always)]
    fn larger(self, a: T, b: T) -> T {
        evaluate::binary(Binary::Max, a, b)
    }

    #[inline(always)]
    fn compare(self, comparison: Comparison, a: T, b: T) -> T {
        if evaluate::compare(comparison, a, b) { T::one() } else { T::zero() }
    }

    #[inline(always)]
    fn select(self, a: T, b: T, c: T) -> T {
        if T::zero() < a { b } else { c }
    }
}

/// Arithmetic in registers of several lanes.
#[derive(Clone, Copy)]
struct Registers<S>(S);

// No closure may be handed to a function that is not always inlined: it would be compiled for the
// smallest machine.
impl<S: Simd> Registers<S> {
    // `Simd::select_f64s` and `Simd::neg_f64s` are not inlined into code for wide registers.
    #[inline(always)]
    fn pick(self, mask: S::m64s, yes: S::f64s, no: S::f64s) -> S::f64s {
        pulp::cast(self.0.select_u64s(mask, pulp::cast(yes), pulp::cast(no)))
    }

    #[inline(always)]
    fn map<const N: usize>(self, a: Lanes<N>, f: impl Fn(S::f64s) -> S::f64s) -> Lanes<N> {
        let mut result = a;
        let (to, rest) = S::as_mut_simd_f64s(&mut result.0);
        debug_assert!(rest.is_empty(), "lanes fill whole registers");
        for a in to {
            *a = f(*a);
        }
        result
    }

    #[inline(always)]
    fn zip<const N: usize>(
        self,
        a: Lanes<N>,
        b: Lanes<N>,
        f: impl Fn(S::f64s, S::f64s) -> S::f64s,
    ) -> Lanes<N> {
        let mut result = a;
        let (to, rest) = S::as_mut_simd_f64s(&mut result.0);
        debug_assert!(rest.is_empty(), "lanes fill whole registers");
        let (b, _) = S::as_simd_f64s(&b.0);
        for (a, b) in to.iter_mut().zip(b) {
            *a = f(*a, *b);
        }
        result
    }
}

impl<S: Simd, const N: usize> Kernel<Lanes<N>> for Registers<S> {
    #[inline(always)]
    fn add(self, a: Lanes<N>, b: Lanes<N>) -> Lanes<N> {
        self.zip(
            a,
            b,
            #[inline(always)]
            |a, b| self.0.add_f64s(a, b),
        )
    }

    #[inline(always)]
    fn sub(self, a: Lanes<N>, b: Lanes<N>) -> Lanes<N> {
        self.zip(
            a,
            b,
            #[inline(always)]
            |a, b| self.0.sub_f64s(a, b),
        )
    }

    #[inline(always)]
    fn mul(self, a: Lanes<N>, b: Lanes<N>) -> Lanes<N> {
        self.zip(
            a,
            b,
            #[inline(always)]
            |a, b| self.0.mul_f64s(a, b),
        )
    }

    #[inline(always)]
    fn div(self, a: Lanes<N>, b: Lanes<N>) -> Lanes<N> {
        self.zip(
            a,
            b,
            #[inline(always)]
            |a, b| self.0.div_f64s(a, b),
        )
    }

    #[inline(always)]
    fn neg(self, a: Lanes<N>) -> Lanes<N> {
        let minus = self.0.splat_f64s(-1.0);
        self.map(
            a,
            #[inline(always)]
            |a| self.0.mul_f64s(a, minus),
        )
    }

    #[inline(always)]
    fn sqrt(self, a: Lanes<N>) -> Lanes<N> {
        self.map(
            a,
            #[inline(always)]
            |a| self.0.sqrt_f64s(a),
        )
    }

    #[inline(always)]
    fn smaller(self, a: Lanes<N>, b: Lanes<N>) -> Lanes<N> {
        self.zip(
            a,
            b,
            #[inline(always)]
            |a, b| self.pick(self.0.less_than_f64s(b, a), b, a),
        )
    }

    #[inline(always)]
    fn larger(self, a: Lanes<N>, b: Lanes<N>) -> Lanes<N> {
        self.zip(
            a,
            b,
            #[inline(always)]
            |a, b| self.pick(self.0.less_than_f64s(a, b), b, a),
        )
    }

    #[inline(always)]
    fn compare(self, comparison: Comparison, a: Lanes<N>, b: Lanes<N>) -> Lanes<N> {
        let simd = self.0;
        let (yes, no) = (simd.splat_f64s(1.0), simd.splat_f64s(0.0));
        macro_rules! holds {
            ($method:ident, $a:expr, $b:expr) => {
                self.zip(
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
    fn select(self, a: Lanes<N>, b: Lanes<N>, c: Lanes<N>) -> Lanes<N> {
        let simd = self.0;
        let zero = simd.splat_f64s(0.0);
        let mut result = a;
        let (to, rest) = S::as_mut_simd_f64s(&mut result.0);
        debug_assert!(rest.is_empty(), "lanes fill whole registers");
        let ((b, _), (c, _)) = (S::as_simd_f64s(&b.0), S::as_simd_f64s(&c.0));
        for ((a, b), c) in to.iter_mut().zip(b).zip(c) {
            *a = self.pick(simd.less_than_f64s(zero, *a), *b, *c);
        }
        result
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
