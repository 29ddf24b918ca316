//! Matrix exponential by scaling and squaring.

use faer::{Mat, MatRef, Scale, prelude::Solve};
use fd_numeric::dense::Dense;

use crate::linalg::balance::balance;

/// Coefficients of the numerator of the (13, 13) Padé approximant, lowest power first.
const PADE: [f64; 14] = [
    64_764_752_532_480_000.0,
    32_382_376_266_240_000.0,
    7_771_770_303_897_600.0,
    1_187_353_796_428_800.0,
    129_060_195_264_000.0,
    10_559_470_521_600.0,
    670_442_572_800.0,
    33_522_128_640.0,
    1_323_241_920.0,
    40_840_800.0,
    960_960.0,
    16_380.0,
    182.0,
    1.0,
];

/// Largest 1-norm for which the approximant's backward error stays below the rounding unit.
const THETA: f64 = 5.371_920_351_148_152;

/// `exp(A)`, after balancing, by a (13, 13) Padé approximant with scaling and squaring.
///
/// N. J. Higham, "The scaling and squaring method for the matrix exponential revisited", SIAM
/// J. Matrix Anal. Appl. 26(4), 2005, algorithm 2.3 with the degree 13 only. Each squaring doubles
/// the error of the slowest mode, so that it is about `ε ‖A‖` for a stiff matrix.
pub(crate) fn exponential(a: MatRef<'_, f64>) -> Mat<f64> {
    let n = a.nrows();
    let scaling = balance(a, Mat::zeros(n, 0).as_ref(), Mat::zeros(0, n).as_ref());
    let balanced = scaling.a(a);
    let ratio = norm_1(balanced.as_ref()) / THETA;
    let squarings = if 1.0 < ratio { ratio.log2().ceil() } else { 0.0 };

    let mut exp = pade(Scale((-squarings).exp2()) * balanced);
    // An infinite norm makes NaN above and needs no squaring to be found out.
    let squarings = if squarings.is_finite() { squarings } else { 0.0 };
    let mut done = 0.0;
    while done < squarings {
        exp = &exp * &exp;
        done += 1.0;
    }
    scaling.undo_a(exp.as_ref())
}

/// The approximant itself, with even and odd powers gathered (Higham's equation 2.12).
fn pade(a: Mat<f64>) -> Mat<f64> {
    let n = a.nrows();
    let identity = Mat::<f64>::identity(n, n);
    let a2 = &a * &a;
    let a4 = &a2 * &a2;
    let a6 = &a4 * &a2;
    let sum = |first: usize| {
        let high = Scale(PADE[first + 8]) * &a2
            + Scale(PADE[first + 10]) * &a4
            + Scale(PADE[first + 12]) * &a6;
        let low = Scale(PADE[first]) * &identity
            + Scale(PADE[first + 2]) * &a2
            + Scale(PADE[first + 4]) * &a4
            + Scale(PADE[first + 6]) * &a6;
        &a6 * high + low
    };
    let even = sum(0);
    let odd = a * sum(1);
    // (even − odd)⁻¹ (even + odd), written so that the exponential of zero is exactly one: an
    // integrator stays an integrator.
    identity + Scale(2.0) * (&even - &odd).lu().solve(odd)
}

/// Largest column sum of absolute values.
fn norm_1(a: MatRef<'_, f64>) -> f64 {
    (0..a.ncols()).map(|j| a.col(j).norm_l1()).fold(0.0, f64::max)
}
