//! What a recursive estimator of one target does, whatever it remembers.

use fd_core::{
    Scalar,
    stage::{GuardReport, Stage},
};

/// A recursive estimator of `θ` in `y = φᵀθ + e` for one target `y`.
///
/// The caller owns `θ` and hands in the same one each time; after a reset it starts from any
/// `θ`, usually zero, which is then the prior mean.
pub trait RlsKernel<T: Scalar>: Stage<T> + Clone {
    /// Number of parameters.
    fn parameters(&self) -> usize;

    /// Learns from one sample. Does not allocate, cannot fail.
    fn update(&mut self, phi: &[T], target: T, theta: &mut [T]);

    /// Writes the variances of the parameters, relative to a noise of variance 1.
    fn variance_into(&self, variance: &mut [T]);

    /// What the safeguards have done since the last reset.
    fn guard(&self) -> GuardReport;
}
