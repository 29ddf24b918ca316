//! What a recursive estimator of one target does, whatever it remembers.

use fd_core::{
    Scalar, Shape, ShapeError,
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

/// Refuses a kernel that has another number of parameters than the equations.
pub(crate) fn check_parameters<T: Scalar>(
    kernel: &impl RlsKernel<T>,
    expected: usize,
) -> Result<(), ShapeError> {
    let (expected, found) = (Shape::new(expected, 1), Shape::new(kernel.parameters(), 1));
    if expected == found {
        return Ok(());
    }
    Err(ShapeError { role: "parameters of the kernel", expected, found })
}
