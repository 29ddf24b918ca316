//! What a recursive estimator asks of its covariance matrix, however that is factorised.

use std::fmt::Debug;

use fd_core::{Buffer, Scalar, ShapeError, StateVisitor};

/// A symmetric positive definite matrix `P` that is changed by rank one at a time.
///
/// Every kind of forgetting in this crate is made of these few operations, so it is written once
/// and runs on every factorisation. None of them allocates.
///
/// What was taken in can be given up again, which is how a window forgets:
///
/// ```
/// use fd_ident::rls::{Covariance, Ud};
///
/// let mut p: Ud<f64> = Covariance::isotropic(2, 1.0)?;
/// let (phi, mut p_phi, mut diagonal) = ([3.0, 1.0], [0.0; 2], [0.0; 2]);
///
/// assert_eq!(p.energy(&phi), 10.0);
/// p.absorb(1.0, &mut p_phi);
/// assert_eq!(p_phi, phi, "P was the unit matrix");
/// // P⁻¹ = I + φφᵀ, whose inverse has the trace 1 + 1/11.
/// assert!((p.trace() - 12.0 / 11.0).abs() < 1e-15);
///
/// let remainder = 1.0 - p.energy(&phi);
/// p.release(1.0, remainder, &mut p_phi);
/// p.diagonal_into(&mut diagonal);
/// assert!(diagonal.iter().all(|v| (v - 1.0).abs() < 1e-14));
/// # Ok::<(), fd_core::ShapeError>(())
/// ```
pub trait Covariance<T: Scalar>: Clone + Debug + Send + Sync {
    /// A vector over the parameters.
    type Parameters: Buffer<T>;

    /// `variance · I` of size `n`.
    ///
    /// # Errors
    ///
    /// Returns an error when the storage is fixed and has another size.
    fn isotropic(n: usize, variance: T) -> Result<Self, ShapeError>;

    /// Starts again from `variance · I`.
    fn restart(&mut self, variance: T);

    /// Returns `φᵀPφ` and remembers `φ` as the direction of the next [`Self::absorb`] or
    /// [`Self::release`].
    fn energy(&mut self, phi: &[T]) -> T;

    /// Forgets those parts of the remembered direction `φ` that are no more than rounding of their
    /// sums. Where `P` is large after a long time without excitation, they would move the estimate.
    fn ignore_rounding(&mut self, phi: &[T]) {
        let _ = phi;
    }

    /// Takes in a sample along the remembered direction, then forgets everywhere:
    /// `P⁻¹ ← (P⁻¹ + w/ρ φφᵀ) / s` with `w ≥ 0`, and `ρ, s > 0`. Writes `Pφ` of the old `P` to
    /// `p_phi` and returns `1 / (ρ + w φᵀPφ)`.
    fn learn(&mut self, weight: T, noise: T, scale: T, p_phi: &mut [T]) -> T;

    /// Takes in information along the remembered direction: `P⁻¹ ← P⁻¹ + w φφᵀ` with `w ≥ 0`.
    /// Writes `Pφ` of the old `P` to `p_phi`.
    fn absorb(&mut self, weight: T, p_phi: &mut [T]) {
        self.learn(weight, T::one(), T::one(), p_phi);
    }

    /// Gives up information along the remembered direction: `P⁻¹ ← P⁻¹ − w φφᵀ` with `w > 0` and
    /// `1 − w φᵀPφ = remainder > 0`. Writes `Pφ` of the old `P` to `p_phi`.
    fn release(&mut self, weight: T, remainder: T, p_phi: &mut [T]);

    /// Computes `P ← factor · P` with `factor > 0`.
    fn scale(&mut self, factor: T);

    /// Sum of the diagonal.
    fn trace(&self) -> T;

    /// Writes the diagonal.
    fn diagonal_into(&self, diagonal: &mut [T]);

    /// Shows the numbers that make up `P` to `visitor`.
    fn visit(&mut self, visitor: &mut dyn StateVisitor<T>);
}

/// What the sums of `Uᵀφ` may be off by, as a part of the sum of their magnitudes: `n` roundings.
pub(crate) fn rounding<T: Scalar>(n: usize) -> T {
    T::from_design(n as f64) * T::default_epsilon()
}

/// Computes `y ← y + factor · x`.
pub(crate) fn add_scaled<T: Scalar>(y: &mut [T], factor: T, x: &[T]) {
    for (y, &x) in y.iter_mut().zip(x) {
        *y += factor * x;
    }
}
