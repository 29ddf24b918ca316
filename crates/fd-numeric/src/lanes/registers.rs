//! Numbers side by side in memory, and the registers that compute with them.
#![expect(
    clippy::inline_always,
    reason = "what is not inlined into code for wide registers is compiled for narrow ones"
)]

use std::{
    fmt::Debug,
    ops::{Deref, DerefMut},
};

use fd_core::Scalar;
use pulp::Simd;

use super::{exponential, sine};

/// A number that can lie side by side with others: `f64` or `f32`. The trait is sealed.
///
/// One row of memory holds [`Self::WIDTH`] of them, in 64 bytes: one register of the widest machine,
/// several of a narrower one.
///
/// ```
/// use fd_numeric::lanes::LaneScalar;
///
/// fn rows<T: LaneScalar>(numbers: usize) -> usize {
///     numbers.div_ceil(T::WIDTH)
/// }
///
/// assert_eq!((rows::<f64>(100), rows::<f32>(100)), (13, 7));
/// ```
pub trait LaneScalar: Scalar + sealed::Sealed {
    /// Numbers in a row: 8 of `f64`, 16 of `f32`.
    const WIDTH: usize;
    /// A row of memory.
    type Row: Copy + Debug + Send + Sync + AsRef<[Self]> + AsMut<[Self]>;
    /// Arithmetic on a machine.
    type Registers<S: Simd>: Registers<Self>;

    /// The same number in all lanes.
    fn row(value: Self) -> Self::Row;

    /// Arithmetic on this machine.
    fn registers<S: Simd>(simd: S) -> Self::Registers<S>;
}

mod sealed {
    /// Rows and registers are made for two kinds of numbers.
    pub trait Sealed {}

    impl Sealed for f64 {}
    impl Sealed for f32 {}
}

/// Arithmetic on as many numbers as a register holds.
pub trait Registers<T: LaneScalar>: Copy {
    /// A register.
    type Reg: Copy;
    /// One truth value per lane.
    type Mask: Copy;

    /// The registers that numbers, such as those of a row, make up; what is left over is left out.
    fn of(numbers: &[T]) -> &[Self::Reg];
    /// The registers that numbers make up, to be changed.
    fn of_mut(numbers: &mut [T]) -> &mut [Self::Reg];
    /// The same number in all lanes.
    fn splat(self, value: T) -> Self::Reg;
    /// `a + b`.
    fn add(self, a: Self::Reg, b: Self::Reg) -> Self::Reg;
    /// `a − b`.
    fn sub(self, a: Self::Reg, b: Self::Reg) -> Self::Reg;
    /// `a b`.
    fn mul(self, a: Self::Reg, b: Self::Reg) -> Self::Reg;
    /// `a / b`.
    fn div(self, a: Self::Reg, b: Self::Reg) -> Self::Reg;
    /// The square root.
    fn sqrt(self, a: Self::Reg) -> Self::Reg;
    /// `|a|`
    fn abs(self, a: Self::Reg) -> Self::Reg;
    /// `a b + c`, rounded once where the machine can.
    fn mul_add(self, a: Self::Reg, b: Self::Reg, c: Self::Reg) -> Self::Reg;
    /// `a < b`; false for what is not a number.
    fn less(self, a: Self::Reg, b: Self::Reg) -> Self::Mask;
    /// `a ≤ b`; false for what is not a number.
    fn at_most(self, a: Self::Reg, b: Self::Reg) -> Self::Mask;
    /// `a = b`.
    fn equal(self, a: Self::Reg, b: Self::Reg) -> Self::Mask;
    /// Both.
    fn both(self, a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// Whether it holds in every lane.
    fn all(self, mask: Self::Mask) -> bool;
    /// `a` where the mask holds, else `b`.
    fn select(self, mask: Self::Mask, a: Self::Reg, b: Self::Reg) -> Self::Reg;
}

/// Registers in memory that begin where a line of the cache does. Those of pulp ask for no alignment,
/// and one that lies across two lines takes two accesses: half as much time again per update, or
/// not, by where the stack happens to be.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Aligned<A>(pub A);

impl<A> Deref for Aligned<A> {
    type Target = A;

    #[inline(always)]
    fn deref(&self) -> &A {
        &self.0
    }
}

impl<A> DerefMut for Aligned<A> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut A {
        &mut self.0
    }
}

macro_rules! lanes {
    (
        $scalar:ident, $row:ident, $count:literal, $registers:ident, $doc:literal,
        $reg:ident, $mask:ident, $bits:ident, $bit:ident, $split:ident, $split_mut:ident,
        $splat:ident, $add:ident, $sub:ident, $mul:ident, $div:ident, $sqrt:ident, $abs:ident,
        $mul_add:ident, $less:ident, $at_most:ident, $equal:ident, $both:ident, $pick:ident
    ) => {
        #[doc = $doc]
        #[derive(Clone, Copy, Debug)]
        #[repr(C, align(64))]
        pub struct $row([$scalar; $count]);

        impl AsRef<[$scalar]> for $row {
            #[inline(always)]
            fn as_ref(&self) -> &[$scalar] {
                &self.0
            }
        }

        impl AsMut<[$scalar]> for $row {
            #[inline(always)]
            fn as_mut(&mut self) -> &mut [$scalar] {
                &mut self.0
            }
        }

        #[doc = $doc]
        #[derive(Clone, Copy, Debug)]
        pub struct $registers<S>(S);

        impl LaneScalar for $scalar {
            const WIDTH: usize = $count;

            type Row = $row;
            type Registers<S: Simd> = $registers<S>;

            #[inline(always)]
            fn row(value: Self) -> $row {
                $row([value; $count])
            }

            #[inline(always)]
            fn registers<S: Simd>(simd: S) -> $registers<S> {
                $registers(simd)
            }
        }

        impl<S: Simd> Registers<$scalar> for $registers<S> {
            type Reg = S::$reg;
            type Mask = S::$mask;

            #[inline(always)]
            fn of(numbers: &[$scalar]) -> &[S::$reg] {
                S::$split(numbers).0
            }

            #[inline(always)]
            fn of_mut(numbers: &mut [$scalar]) -> &mut [S::$reg] {
                S::$split_mut(numbers).0
            }

            #[inline(always)]
            fn splat(self, value: $scalar) -> S::$reg {
                self.0.$splat(value)
            }

            #[inline(always)]
            fn add(self, a: S::$reg, b: S::$reg) -> S::$reg {
                self.0.$add(a, b)
            }

            #[inline(always)]
            fn sub(self, a: S::$reg, b: S::$reg) -> S::$reg {
                self.0.$sub(a, b)
            }

            #[inline(always)]
            fn mul(self, a: S::$reg, b: S::$reg) -> S::$reg {
                self.0.$mul(a, b)
            }

            #[inline(always)]
            fn div(self, a: S::$reg, b: S::$reg) -> S::$reg {
                self.0.$div(a, b)
            }

            #[inline(always)]
            fn sqrt(self, a: S::$reg) -> S::$reg {
                self.0.$sqrt(a)
            }

            #[inline(always)]
            fn abs(self, a: S::$reg) -> S::$reg {
                self.0.$abs(a)
            }

            #[inline(always)]
            fn mul_add(self, a: S::$reg, b: S::$reg, c: S::$reg) -> S::$reg {
                self.0.$mul_add(a, b, c)
            }

            #[inline(always)]
            fn less(self, a: S::$reg, b: S::$reg) -> S::$mask {
                self.0.$less(a, b)
            }

            #[inline(always)]
            fn at_most(self, a: S::$reg, b: S::$reg) -> S::$mask {
                self.0.$at_most(a, b)
            }

            #[inline(always)]
            fn equal(self, a: S::$reg, b: S::$reg) -> S::$mask {
                self.0.$equal(a, b)
            }

            #[inline(always)]
            fn both(self, a: S::$mask, b: S::$mask) -> S::$mask {
                self.0.$both(a, b)
            }

            #[inline(always)]
            fn all(self, mask: S::$mask) -> bool {
                let (ones, zeros) = (self.0.$splat(1.0), self.0.$splat(0.0));
                let lanes = self.select(mask, zeros, ones);
                // Where masks are bits, this becomes one test of the bits.
                let bits: S::$bits = pulp::cast(lanes);
                let words: &[$bit] = pulp::bytemuck::cast_slice(std::slice::from_ref(&bits));
                words.iter().fold(0, |any, word| any | word) == 0
            }

            // pulp's `select` of floats is not inlined into code for wide registers.
            #[inline(always)]
            fn select(self, mask: S::$mask, a: S::$reg, b: S::$reg) -> S::$reg {
                pulp::cast(self.0.$pick(mask, pulp::cast(a), pulp::cast(b)))
            }
        }
    };
}

lanes!(
    f64,
    Doubles,
    8,
    DoubleRegisters,
    "Double precision, side by side.",
    f64s,
    m64s,
    u64s,
    u64,
    as_simd_f64s,
    as_mut_simd_f64s,
    splat_f64s,
    add_f64s,
    sub_f64s,
    mul_f64s,
    div_f64s,
    sqrt_f64s,
    abs_f64s,
    mul_add_e_f64s,
    less_than_f64s,
    less_than_or_equal_f64s,
    equal_f64s,
    and_m64s,
    select_u64s
);
lanes!(
    f32,
    Singles,
    16,
    SingleRegisters,
    "Single precision, side by side.",
    f32s,
    m32s,
    u32s,
    u32,
    as_simd_f32s,
    as_mut_simd_f32s,
    splat_f32s,
    add_f32s,
    sub_f32s,
    mul_f32s,
    div_f32s,
    sqrt_f32s,
    abs_f32s,
    mul_add_e_f32s,
    less_than_f32s,
    less_than_or_equal_f32s,
    equal_f32s,
    and_m32s,
    select_u32s
);

/// The functions of [`elementary`](super::elementary) in all lanes, where their arguments allow it.
impl<S: Simd> DoubleRegisters<S> {
    /// `sin(a)` of angles up to [`SMALL_ANGLE`](super::elementary::SMALL_ANGLE).
    #[inline(always)]
    pub fn sin_small(self, a: S::f64s) -> S::f64s {
        sine::sin_small(self.0, a)
    }

    /// `sin(a)` of angles up to [`FAR_ANGLE`](super::elementary::FAR_ANGLE).
    #[inline(always)]
    pub fn sin_near(self, a: S::f64s) -> S::f64s {
        sine::sin_near(self.0, a)
    }

    /// `cos(a)` of angles up to [`SMALL_ANGLE`](super::elementary::SMALL_ANGLE).
    #[inline(always)]
    pub fn cos_small(self, a: S::f64s) -> S::f64s {
        sine::cos_small(self.0, a)
    }

    /// `cos(a)` of angles up to [`FAR_ANGLE`](super::elementary::FAR_ANGLE).
    #[inline(always)]
    pub fn cos_near(self, a: S::f64s) -> S::f64s {
        sine::cos_near(self.0, a)
    }

    /// `exp(a)` up to [`FAR_EXPONENT`](super::elementary::FAR_EXPONENT).
    #[inline(always)]
    pub fn exp_near(self, a: S::f64s) -> S::f64s {
        exponential::exp_near(self.0, a)
    }

    /// `tanh(a)`.
    #[inline(always)]
    pub fn tanh(self, a: S::f64s) -> S::f64s {
        exponential::tanh_of(self.0, a)
    }
}
