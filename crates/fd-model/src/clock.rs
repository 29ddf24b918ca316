//! The one rule for comparing a sampled time with an instant in a specification.

use crate::domain::SampleTime;

/// Whether the sample at time `t` is at or after the instant `at`, both in seconds.
///
/// A sample up to a millionth of a sample time early counts as there, so that `at = 0.3` means
/// sample 3 at 0.1 s although `3 · 0.1` and `0.3` differ in floating point.
pub(crate) fn reached(t: f64, at: f64, ts: SampleTime) -> bool {
    at <= t + 1e-6 * ts.seconds()
}
