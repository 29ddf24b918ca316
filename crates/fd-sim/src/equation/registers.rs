//! Arithmetic on several numbers at once, with the registers of the machine.
#![expect(
    clippy::inline_always,
    reason = "what is not inlined into code for wide registers is compiled for narrow ones"
)]

use std::marker::PhantomData;

use pulp::Simd;

use super::{
    exponential,
    expr::Comparison,
    kernel::{Kernel, Work},
    sine,
    value::{Lanes, Value},
};

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
    fn sin(self, to: &mut Lanes<N>, a: &Lanes<N>) {
        let simd = self.0;
        match Size::of(a, sine::SMALL, sine::FAR) {
            Size::Small => Self::map(
                to,
                a,
                #[inline(always)]
                |a| sine::sin_small(simd, a),
            ),
            Size::Near => Self::map(
                to,
                a,
                #[inline(always)]
                |a| sine::sin_near(simd, a),
            ),
            Size::Far => each(to, a, sine::sin),
        }
    }

    #[inline(always)]
    fn cos(self, to: &mut Lanes<N>, a: &Lanes<N>) {
        let simd = self.0;
        match Size::of(a, sine::SMALL, sine::FAR) {
            Size::Small => Self::map(
                to,
                a,
                #[inline(always)]
                |a| sine::cos_small(simd, a),
            ),
            Size::Near => Self::map(
                to,
                a,
                #[inline(always)]
                |a| sine::cos_near(simd, a),
            ),
            Size::Far => each(to, a, sine::cos),
        }
    }

    #[inline(always)]
    fn exp(self, to: &mut Lanes<N>, a: &Lanes<N>) {
        let simd = self.0;
        match Size::of(a, 0.0, exponential::FAR) {
            Size::Small | Size::Near => Self::map(
                to,
                a,
                #[inline(always)]
                |a| exponential::exp_near(simd, a),
            ),
            Size::Far => each(to, a, exponential::exp),
        }
    }

    #[inline(always)]
    fn tanh(self, to: &mut Lanes<N>, a: &Lanes<N>) {
        let simd = self.0;
        Self::map(
            to,
            a,
            #[inline(always)]
            |a| exponential::tanh_of(simd, a),
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

/// Size of the largest of several numbers.
enum Size {
    /// All are small.
    Small,
    /// None is far from zero; NaN is not.
    Near,
    Far,
}

impl Size {
    #[inline(always)]
    fn of<const N: usize>(a: &Lanes<N>, small: f64, far: f64) -> Self {
        let (mut is_small, mut is_far) = (true, false);
        for i in 0..N {
            is_small &= a.0[i].abs() <= small;
            is_far |= a.0[i].abs() > far;
        }
        match (is_small, is_far) {
            (true, _) => Self::Small,
            (false, false) => Self::Near,
            (false, true) => Self::Far,
        }
    }
}

/// A function of each lane, one after the other: for what is rare.
#[cold]
#[inline(never)]
fn each<const N: usize>(to: &mut Lanes<N>, a: &Lanes<N>, f: fn(f64) -> f64) {
    *to = a.map(f);
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
