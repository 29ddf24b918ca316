//! Sine and cosine, the same bits for one number and for several side by side.
//!
//! The sine of a library takes one number at a time. Here the multiple of π/2 is taken off in four
//! exact parts (W. J. Cody & W. Waite, *Software Manual for the Elementary Functions*, 1980) and
//! the rest goes into the polynomials of Sun's fdlibm (`k_sin.c`, `k_cos.c`, 1993): sums and
//! products alone, which all registers round in the same way. Results are within one unit in the
//! last place. Beyond [`FAR`], where the parts are no longer exact, the library is asked.
#![expect(
    clippy::inline_always,
    reason = "what is not inlined into code for wide registers is compiled for narrow ones"
)]
#![expect(clippy::excessive_precision, reason = "coefficients as they were published")]

use std::f64::consts::FRAC_2_PI;

use pulp::Simd;

/// Largest angle that is reduced here: up to 2¹⁶ quarters of a turn.
pub const FAR: f64 = 1e5;
/// Up to here there is nothing to take off.
pub const SMALL: f64 = 0.75;

/// π/2 in parts: three of 36 bits, whose products with up to 2¹⁶ are exact, and the rest.
const QUARTER: [f64; 4] = [
    1.570_796_326_792_333_3,
    2.563_344_151_266_318_4e-12,
    3.282_003_542_826_844_6e-22,
    4.665_590_917_179_985e-33,
];
/// What is added to a small number to round it to a whole one, whose lowest bits are then those of
/// the sum: 1.5 · 2⁵².
pub(super) const ROUNDING: f64 = 6_755_399_441_055_744.0;
/// Coefficients of `x³`, `x⁵`, … of the sine up to π/4.
const SINE: [f64; 6] = [
    -1.666_666_666_666_663_243_48e-1,
    8.333_333_333_322_489_461_24e-3,
    -1.984_126_982_985_794_931_34e-4,
    2.755_731_370_707_006_767_89e-6,
    -2.505_076_025_340_686_341_95e-8,
    1.589_690_995_211_550_102_21e-10,
];
/// Coefficients of `x⁴`, `x⁶`, … of the cosine up to π/4.
const COSINE: [f64; 6] = [
    4.166_666_666_666_660_190_37e-2,
    -1.388_888_888_887_410_957_49e-3,
    2.480_158_728_947_672_941_78e-5,
    -2.755_731_435_139_066_330_35e-7,
    2.087_572_321_298_174_827_90e-9,
    -1.135_964_755_778_819_482_65e-11,
];

/// `sin(x)`.
#[inline]
#[must_use]
pub fn sin(x: f64) -> f64 {
    if x.abs() <= SMALL {
        sine(pulp::Scalar, Angle::small(pulp::Scalar, x))
    } else if x.abs() > FAR {
        x.sin()
    } else {
        ahead(x, 0)
    }
}

/// `cos(x)`.
#[inline]
#[must_use]
pub fn cos(x: f64) -> f64 {
    if x.abs() <= SMALL {
        cosine(pulp::Scalar, Angle::small(pulp::Scalar, x))
    } else if x.abs() > FAR {
        x.cos()
    } else {
        ahead(x, 1)
    }
}

/// The sine so many quarters of a turn further, of one number: sine or cosine alone is computed.
fn ahead(x: f64, quarters: u64) -> f64 {
    let angle = reduce(pulp::Scalar, x);
    match angle.quarters.wrapping_add(quarters) & 3 {
        0 => sine(pulp::Scalar, angle),
        1 => cosine(pulp::Scalar, angle),
        2 => -sine(pulp::Scalar, angle),
        _ => -cosine(pulp::Scalar, angle),
    }
}

/// `sin(x)` of angles up to [`SMALL`].
#[inline(always)]
pub(super) fn sin_small<S: Simd>(simd: S, x: S::f64s) -> S::f64s {
    sine(simd, Angle::small(simd, x))
}

/// `cos(x)` of angles up to [`SMALL`].
#[inline(always)]
pub(super) fn cos_small<S: Simd>(simd: S, x: S::f64s) -> S::f64s {
    cosine(simd, Angle::small(simd, x))
}

/// `sin(x)` of angles up to [`FAR`].
#[inline(always)]
pub(super) fn sin_near<S: Simd>(simd: S, x: S::f64s) -> S::f64s {
    let angle = reduce(simd, x);
    turned(simd, angle.quarters, sine(simd, angle), cosine(simd, angle))
}

/// `cos(x)` of angles up to [`FAR`]: the sine a quarter further.
#[inline(always)]
pub(super) fn cos_near<S: Simd>(simd: S, x: S::f64s) -> S::f64s {
    let angle = reduce(simd, x);
    let quarters = simd.add_u64s(angle.quarters, simd.splat_u64s(1));
    turned(simd, quarters, sine(simd, angle), cosine(simd, angle))
}

/// An angle as quarters of a turn, of which the two lowest bits count, and a rest within ±π/4 in
/// two parts.
#[derive(Clone, Copy)]
struct Angle<S: Simd> {
    quarters: S::u64s,
    rest: S::f64s,
    tail: S::f64s,
}

impl<S: Simd> Angle<S> {
    #[inline(always)]
    fn small(simd: S, x: S::f64s) -> Self {
        Self { quarters: simd.splat_u64s(0), rest: x, tail: simd.splat_f64s(0.0) }
    }
}

/// Takes off the nearest multiple of π/2. Of an angle that is not above [`SMALL`] that is zero, and
/// the angle stays as it is.
#[inline(always)]
fn reduce<S: Simd>(simd: S, x: S::f64s) -> Angle<S> {
    let [first, second, third, fourth] = QUARTER;
    let rounding = simd.splat_f64s(ROUNDING);
    let sum = simd.add_f64s(simd.mul_f64s(x, simd.splat_f64s(FRAC_2_PI)), rounding);
    let quarters = simd.sub_f64s(sum, rounding);
    let rest = simd.sub_f64s(x, simd.mul_f64s(quarters, simd.splat_f64s(first)));
    let (rest, second) = subtract(simd, rest, simd.mul_f64s(quarters, simd.splat_f64s(second)));
    let (rest, third) = subtract(simd, rest, simd.mul_f64s(quarters, simd.splat_f64s(third)));
    let fourth = simd.mul_f64s(quarters, simd.splat_f64s(fourth));
    let more = simd.sub_f64s(fourth, simd.add_f64s(second, third));
    let (rest, tail) = subtract(simd, rest, more);
    Angle { quarters: pulp::cast(sum), rest, tail }
}

/// A difference and its rounding error (fast two-sum; T. J. Dekker 1971). Where `b` is the larger
/// one, both are multiples of so coarse a unit that the difference is exact.
#[inline(always)]
fn subtract<S: Simd>(simd: S, a: S::f64s, b: S::f64s) -> (S::f64s, S::f64s) {
    let difference = simd.sub_f64s(a, b);
    (difference, simd.sub_f64s(simd.sub_f64s(a, difference), b))
}

/// The sine of a rest.
#[inline(always)]
fn sine<S: Simd>(simd: S, Angle { rest: x, tail, .. }: Angle<S>) -> S::f64s {
    let z = simd.mul_f64s(x, x);
    let w = simd.mul_f64s(z, z);
    let low = quadratic(simd, [SINE[1], SINE[2], SINE[3]], z);
    let high = linear(simd, [SINE[4], SINE[5]], z);
    let r = simd.add_f64s(low, simd.mul_f64s(simd.mul_f64s(z, w), high));
    let v = simd.mul_f64s(z, x);
    let half = simd.mul_f64s(simd.splat_f64s(0.5), tail);
    let inner = simd.sub_f64s(half, simd.mul_f64s(v, r));
    let small = simd.sub_f64s(simd.mul_f64s(z, inner), tail);
    let first = simd.mul_f64s(v, simd.splat_f64s(SINE[0]));
    simd.sub_f64s(x, simd.sub_f64s(small, first))
}

/// The cosine of a rest.
#[inline(always)]
fn cosine<S: Simd>(simd: S, Angle { rest: x, tail, .. }: Angle<S>) -> S::f64s {
    let one = simd.splat_f64s(1.0);
    let z = simd.mul_f64s(x, x);
    let w = simd.mul_f64s(z, z);
    let low = simd.mul_f64s(z, quadratic(simd, [COSINE[0], COSINE[1], COSINE[2]], z));
    let high = quadratic(simd, [COSINE[3], COSINE[4], COSINE[5]], z);
    let r = simd.add_f64s(low, simd.mul_f64s(simd.mul_f64s(w, w), high));
    let half = simd.mul_f64s(simd.splat_f64s(0.5), z);
    let most = simd.sub_f64s(one, half);
    let rounded = simd.sub_f64s(simd.sub_f64s(one, most), half);
    let small = simd.sub_f64s(simd.mul_f64s(z, r), simd.mul_f64s(x, tail));
    simd.add_f64s(most, simd.add_f64s(rounded, small))
}

/// `a + b*z`.
#[inline(always)]
fn linear<S: Simd>(simd: S, [a, b]: [f64; 2], z: S::f64s) -> S::f64s {
    simd.add_f64s(simd.splat_f64s(a), simd.mul_f64s(z, simd.splat_f64s(b)))
}

/// `a + z*(b + c*z)`.
#[inline(always)]
fn quadratic<S: Simd>(simd: S, [a, b, c]: [f64; 3], z: S::f64s) -> S::f64s {
    simd.add_f64s(simd.splat_f64s(a), simd.mul_f64s(z, linear(simd, [b, c], z)))
}

/// The sine of an angle with these quarters, from sine and cosine of its rest.
#[inline(always)]
fn turned<S: Simd>(simd: S, quarters: S::u64s, sine: S::f64s, cosine: S::f64s) -> S::f64s {
    let [one, two] = [simd.splat_u64s(1), simd.splat_u64s(2)];
    let is_odd = simd.equal_u64s(simd.and_u64s(quarters, one), one);
    let is_behind = simd.equal_u64s(simd.and_u64s(quarters, two), two);
    let value = simd.select_u64s(is_odd, pulp::cast(cosine), pulp::cast(sine));
    let minus = simd.splat_u64s((-0.0_f64).to_bits());
    let turned = simd.xor_u64s(value, minus);
    pulp::cast(simd.select_u64s(is_behind, turned, value))
}
