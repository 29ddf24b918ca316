//! Arithmetic on several numbers at once, with the registers of the machine.
#![expect(
    clippy::inline_always,
    reason = "what is not inlined into code for wide registers is compiled for narrow ones"
)]

use std::marker::PhantomData;

use fd_numeric::lanes::{self, DoubleRegisters, Registers, Simd, elementary};

use super::{
    expr::Comparison,
    value::{Kernel, Lanes, Value, Work},
};

/// Arithmetic in registers of several lanes.
#[derive(Clone, Copy)]
struct Wide<S>(DoubleRegisters<S>);

// Loops are written out: a closure handed to an iterator would be compiled for the smallest
// machine.
impl<S: Simd> Wide<S> {
    #[inline(always)]
    fn map<const N: usize>(to: &mut Lanes<N>, a: &Lanes<N>, f: impl Fn(S::f64s) -> S::f64s) {
        let to = DoubleRegisters::<S>::of_mut(&mut to.0);
        let a = DoubleRegisters::<S>::of(&a.0);
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
        let to = DoubleRegisters::<S>::of_mut(&mut to.0);
        let (a, b) = (DoubleRegisters::<S>::of(&a.0), DoubleRegisters::<S>::of(&b.0));
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
        let to = DoubleRegisters::<S>::of_mut(&mut to.0);
        let (a, b) = (DoubleRegisters::<S>::of(&a.0), DoubleRegisters::<S>::of(&b.0));
        let c = DoubleRegisters::<S>::of(&c.0);
        for i in 0..N / S::F64_LANES {
            to[i] = f(a[i], b[i], c[i]);
        }
    }
}

impl<S: Simd, const N: usize> Kernel<Lanes<N>> for Wide<S> {
    #[inline(always)]
    fn add(self, to: &mut Lanes<N>, a: &Lanes<N>, b: &Lanes<N>) {
        let m = self.0;
        Self::zip(
            to,
            a,
            b,
            #[inline(always)]
            |a, b| m.add(a, b),
        );
    }

    #[inline(always)]
    fn sub(self, to: &mut Lanes<N>, a: &Lanes<N>, b: &Lanes<N>) {
        let m = self.0;
        Self::zip(
            to,
            a,
            b,
            #[inline(always)]
            |a, b| m.sub(a, b),
        );
    }

    #[inline(always)]
    fn mul(self, to: &mut Lanes<N>, a: &Lanes<N>, b: &Lanes<N>) {
        let m = self.0;
        Self::zip(
            to,
            a,
            b,
            #[inline(always)]
            |a, b| m.mul(a, b),
        );
    }

    #[inline(always)]
    fn div(self, to: &mut Lanes<N>, a: &Lanes<N>, b: &Lanes<N>) {
        let m = self.0;
        Self::zip(
            to,
            a,
            b,
            #[inline(always)]
            |a, b| m.div(a, b),
        );
    }

    #[inline(always)]
    fn mul_add(self, to: &mut Lanes<N>, a: &Lanes<N>, b: &Lanes<N>, c: &Lanes<N>) {
        let m = self.0;
        Self::zip3(
            to,
            [a, b, c],
            #[inline(always)]
            |a, b, c| m.add(m.mul(a, b), c),
        );
    }

    #[inline(always)]
    fn mul_sub(self, to: &mut Lanes<N>, a: &Lanes<N>, b: &Lanes<N>, c: &Lanes<N>) {
        let m = self.0;
        Self::zip3(
            to,
            [a, b, c],
            #[inline(always)]
            |a, b, c| m.sub(m.mul(a, b), c),
        );
    }

    #[inline(always)]
    fn sub_mul(self, to: &mut Lanes<N>, a: &Lanes<N>, b: &Lanes<N>, c: &Lanes<N>) {
        let m = self.0;
        Self::zip3(
            to,
            [a, b, c],
            #[inline(always)]
            |a, b, c| m.sub(c, m.mul(a, b)),
        );
    }

    #[inline(always)]
    fn neg(self, to: &mut Lanes<N>, a: &Lanes<N>) {
        let m = self.0;
        let minus = m.splat(-1.0);
        Self::map(
            to,
            a,
            #[inline(always)]
            |a| m.mul(a, minus),
        );
    }

    #[inline(always)]
    fn sqrt(self, to: &mut Lanes<N>, a: &Lanes<N>) {
        let m = self.0;
        Self::map(
            to,
            a,
            #[inline(always)]
            |a| m.sqrt(a),
        );
    }

    #[inline(always)]
    fn sin(self, to: &mut Lanes<N>, a: &Lanes<N>) {
        let m = self.0;
        match Size::of(a, elementary::SMALL_ANGLE, elementary::FAR_ANGLE) {
            Size::Small => Self::map(
                to,
                a,
                #[inline(always)]
                |a| m.sin_small(a),
            ),
            Size::Near => Self::map(
                to,
                a,
                #[inline(always)]
                |a| m.sin_near(a),
            ),
            Size::Far => each(to, a, elementary::sin),
        }
    }

    #[inline(always)]
    fn cos(self, to: &mut Lanes<N>, a: &Lanes<N>) {
        let m = self.0;
        match Size::of(a, elementary::SMALL_ANGLE, elementary::FAR_ANGLE) {
            Size::Small => Self::map(
                to,
                a,
                #[inline(always)]
                |a| m.cos_small(a),
            ),
            Size::Near => Self::map(
                to,
                a,
                #[inline(always)]
                |a| m.cos_near(a),
            ),
            Size::Far => each(to, a, elementary::cos),
        }
    }

    #[inline(always)]
    fn exp(self, to: &mut Lanes<N>, a: &Lanes<N>) {
        let m = self.0;
        match Size::of(a, 0.0, elementary::FAR_EXPONENT) {
            Size::Small | Size::Near => Self::map(
                to,
                a,
                #[inline(always)]
                |a| m.exp_near(a),
            ),
            Size::Far => each(to, a, elementary::exp),
        }
    }

    #[inline(always)]
    fn tanh(self, to: &mut Lanes<N>, a: &Lanes<N>) {
        let m = self.0;
        Self::map(
            to,
            a,
            #[inline(always)]
            |a| m.tanh(a),
        );
    }

    #[inline(always)]
    fn smaller(self, to: &mut Lanes<N>, a: &Lanes<N>, b: &Lanes<N>) {
        let m = self.0;
        Self::zip(
            to,
            a,
            b,
            #[inline(always)]
            |a, b| m.select(m.less(b, a), b, a),
        );
    }

    #[inline(always)]
    fn larger(self, to: &mut Lanes<N>, a: &Lanes<N>, b: &Lanes<N>) {
        let m = self.0;
        Self::zip(
            to,
            a,
            b,
            #[inline(always)]
            |a, b| m.select(m.less(a, b), b, a),
        );
    }

    #[inline(always)]
    fn clamp(self, to: &mut Lanes<N>, a: &Lanes<N>, b: &Lanes<N>, c: &Lanes<N>) {
        let m = self.0;
        Self::zip3(
            to,
            [a, b, c],
            #[inline(always)]
            |a, b, c| {
                let above = m.select(m.less(a, b), b, a);
                m.select(m.less(c, above), c, above)
            },
        );
    }

    #[inline(always)]
    fn compare(self, comparison: Comparison, to: &mut Lanes<N>, a: &Lanes<N>, b: &Lanes<N>) {
        let m = self.0;
        let (yes, no) = (m.splat(1.0), m.splat(0.0));
        macro_rules! holds {
            ($method:ident, $a:expr, $b:expr) => {
                Self::zip(
                    to,
                    $a,
                    $b,
                    #[inline(always)]
                    |a, b| m.select(m.$method(a, b), yes, no),
                )
            };
        }
        match comparison {
            Comparison::Less => holds!(less, a, b),
            Comparison::LessEqual => holds!(at_most, a, b),
            Comparison::Greater => holds!(less, b, a),
            Comparison::GreaterEqual => holds!(at_most, b, a),
            Comparison::Equal => holds!(equal, a, b),
        }
    }

    #[inline(always)]
    fn select(self, to: &mut Lanes<N>, a: &Lanes<N>, b: &Lanes<N>, c: &Lanes<N>) {
        let m = self.0;
        let zero = m.splat(0.0);
        Self::zip3(
            to,
            [a, b, c],
            #[inline(always)]
            |a, b, c| m.select(m.less(zero, a), b, c),
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
    pub work: W,
    pub lanes: PhantomData<V>,
}

impl<const N: usize, W: Work<Lanes<N>>> lanes::Work<f64> for InLanes<W, Lanes<N>> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, registers: DoubleRegisters<S>) {
        self.work.run(Wide(registers));
    }
}
