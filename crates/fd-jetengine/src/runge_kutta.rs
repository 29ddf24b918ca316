//! The classical Runge-Kutta method with fixed steps between samples.

use fd_core::Scalar;
use fd_model::SampleTime;

/// The fewest equal steps of at most `longest` (s) in a sample: their number and length (s).
pub(crate) fn substeps(ts: SampleTime, longest: f64) -> (u32, f64) {
    // A multiple of the longest step must not gain a step by rounding.
    let count = (ts.seconds() / longest * (1.0 - 1e-12)).ceil().max(1.0);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at least 1")]
    let count = count as u32;
    (count, ts.seconds() / f64::from(count))
}

/// One step of `h` seconds from `x`, whose rates `k1` are known.
pub(crate) fn step<T: Scalar, const N: usize>(
    x: &[T; N],
    k1: &[T; N],
    h: f64,
    rates: impl Fn(&[T; N]) -> [T; N],
) -> [T; N] {
    let half = T::from_design(0.5 * h);
    let shifted = |k: &[T; N], h: T| -> [T; N] { std::array::from_fn(|i| x[i] + h * k[i]) };
    let k2 = rates(&shifted(k1, half));
    let k3 = rates(&shifted(&k2, half));
    let k4 = rates(&shifted(&k3, T::from_design(h)));
    let (two, sixth) = (T::from_design(2.0), T::from_design(h / 6.0));
    std::array::from_fn(|i| x[i] + sixth * (k1[i] + two * (k2[i] + k3[i]) + k4[i]))
}
