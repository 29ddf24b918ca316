//! Exponential and hyperbolic tangent, the same bits for one number and for several side by side.
//!
//! As in `sine`: sums, products and quotients alone. The power of two is taken off in two exact
//! parts, and `exp(r) − 1` of the rest is the rational function of Sun's fdlibm (`s_expm1.c`, 1993).
//! The exponential is within one unit in the last place, the tangent within two and a half.
#![expect(
    clippy::inline_always,
    reason = "what is not inlined into code for wide registers is compiled for narrow ones"
)]
#![expect(clippy::excessive_precision, reason = "coefficients as they were published")]

use std::f64::consts::LOG2_E;

use pulp::Simd;

use super::sine::ROUNDING;

/// Largest exponent of which the exponential is computed here: no power of two on the way is
/// beyond what a number can hold.
pub const FAR: f64 = 700.0;
/// From here on a hyperbolic tangent is 1.
const ONE: f64 = 22.0;

/// ln 2 in a part of 32 bits, whose products with powers are exact, and the rest.
const LN_2: [f64; 2] = [6.931_471_803_691_238_164_9e-1, 1.908_214_929_270_587_700_02e-10];
/// Coefficients of powers of `r²/2`.
const EXPM1: [f64; 5] = [
    -3.333_333_333_333_313_164_28e-2,
    1.587_301_587_254_814_601_65e-3,
    -7.936_507_578_674_879_424_73e-5,
    4.008_217_827_329_362_395_52e-6,
    -2.010_992_181_836_243_713_26e-7,
];

/// `exp(x)`.
#[inline]
#[must_use]
pub fn exp(x: f64) -> f64 {
    if x.abs() > FAR { x.exp() } else { exp_near(pulp::Scalar, x) }
}

/// `tanh(x)`.
#[inline]
#[must_use]
pub fn tanh(x: f64) -> f64 {
    tanh_of(pulp::Scalar, x)
}

/// `exp(x)` up to [`FAR`].
#[inline(always)]
pub(super) fn exp_near<S: Simd>(simd: S, x: S::f64s) -> S::f64s {
    let (scale, rest) = split(simd, x);
    simd.mul_f64s(scale, simd.add_f64s(simd.splat_f64s(1.0), rest))
}

/// `tanh(x) = −t/(t + 2)` with `t = exp(−2 |x|) − 1`, and the sign of `x`.
#[inline(always)]
pub(super) fn tanh_of<S: Simd>(simd: S, x: S::f64s) -> S::f64s {
    let sign = simd.splat_u64s((-0.0_f64).to_bits());
    let size = simd.splat_u64s(!(-0.0_f64).to_bits());
    let one = simd.splat_f64s(ONE);
    let distance = pulp::cast(simd.and_u64s(pulp::cast(x), size));
    let is_one = simd.less_than_f64s(one, distance);
    let distance = simd.select_u64s(is_one, pulp::cast(one), pulp::cast(distance));
    let (scale, rest) = split(simd, simd.mul_f64s(simd.splat_f64s(-2.0), pulp::cast(distance)));
    let power = simd.sub_f64s(scale, simd.splat_f64s(1.0));
    let t = simd.add_f64s(simd.mul_f64s(scale, rest), power);
    let tanh = simd.div_f64s(t, simd.add_f64s(t, simd.splat_f64s(2.0)));
    let tanh = simd.and_u64s(pulp::cast(tanh), size);
    pulp::cast(simd.or_u64s(tanh, simd.and_u64s(pulp::cast(x), sign)))
}

/// The power of two next to `exp(x)`, and what `exp(x)` is above it, as a multiple of it.
#[inline(always)]
fn split<S: Simd>(simd: S, x: S::f64s) -> (S::f64s, S::f64s) {
    let rounding = simd.splat_f64s(ROUNDING);
    let sum = simd.add_f64s(simd.mul_f64s(x, simd.splat_f64s(LOG2_E)), rounding);
    let power = simd.sub_f64s(sum, rounding);
    // The lowest bits of the sum are the power: shifted to where an exponent is, and biased.
    let shifted = simd.mul_u64s(pulp::cast(sum), simd.splat_u64s(1 << 52));
    let scale = simd.add_u64s(shifted, simd.splat_u64s(1.0_f64.to_bits()));

    let [high, low] = LN_2;
    let high = simd.sub_f64s(x, simd.mul_f64s(power, simd.splat_f64s(high)));
    let low = simd.mul_f64s(power, simd.splat_f64s(low));
    let r = simd.sub_f64s(high, low);
    let tail = simd.sub_f64s(simd.sub_f64s(high, r), low);
    (pulp::cast(scale), expm1(simd, r, tail))
}

/// `exp(r + tail) − 1` within ± ½ ln 2.
#[inline(always)]
fn expm1<S: Simd>(simd: S, r: S::f64s, tail: S::f64s) -> S::f64s {
    let half = simd.mul_f64s(simd.splat_f64s(0.5), r);
    let square = simd.mul_f64s(r, half);
    let mut sum = simd.splat_f64s(EXPM1[4]);
    for i in (0..4).rev() {
        sum = simd.add_f64s(simd.splat_f64s(EXPM1[i]), simd.mul_f64s(square, sum));
    }
    let sum = simd.add_f64s(simd.splat_f64s(1.0), simd.mul_f64s(square, sum));
    let t = simd.sub_f64s(simd.splat_f64s(3.0), simd.mul_f64s(sum, half));
    let below = simd.sub_f64s(simd.splat_f64s(6.0), simd.mul_f64s(r, t));
    let e = simd.mul_f64s(square, simd.div_f64s(simd.sub_f64s(sum, t), below));
    let e = simd.sub_f64s(simd.mul_f64s(r, simd.sub_f64s(e, tail)), tail);
    simd.sub_f64s(r, simd.sub_f64s(e, square))
}
