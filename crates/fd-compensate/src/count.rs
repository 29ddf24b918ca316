//! From a computed number of samples to a count.

/// The whole part of `value`; 0 for negative numbers and NaN.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a float-to-integer cast saturates, which is what is wanted here"
)]
pub(crate) fn whole(value: f64) -> usize {
    value as usize
}
