//! The scalar product of short vectors.

use fd_core::Scalar;

/// The scalar product of two slices, summed in order; the shorter one counts.
///
/// For long signals in design time see [`wide::dot`](crate::wide::dot), which rounds differently.
///
/// ```
/// assert_eq!(fd_numeric::dot(&[1.0, 2.0, 3.0], &[4.0, 5.0, 6.0]), 32.0);
/// ```
#[must_use]
// Not marked for inlining: unrolled into its callers, it costs an update of recursive least squares half as many
// instructions again (fd-ident/tests/suite/instructions.rs).
pub fn dot<T: Scalar>(a: &[T], b: &[T]) -> T {
    a.iter().zip(b).fold(T::zero(), |sum, (&a, &b)| sum + a * b)
}
