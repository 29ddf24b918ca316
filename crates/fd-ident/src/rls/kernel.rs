//! What a recursive estimator of one target does, whatever it remembers.

use fd_core::{
    Scalar, Shape, ShapeError,
    stage::{GuardReport, Stage},
};

/// A recursive estimator of `θ` in `y = φᵀθ + e` for one target `y`.
///
/// The caller owns `θ` and hands in the same one each time; after a reset it starts from any
/// `θ`, usually zero, which is then the prior mean.
///
/// A kernel knows nothing of regressors. [`RecursiveArx`](crate::arx::RecursiveArx) makes them and
/// keeps one kernel per residual channel, so another way of updating a covariance is a kernel, and
/// is at once an [`Identifier`](fd_core::stage::Identifier).
///
/// ```
/// use fd_ident::rls::{QrRls, RlsDesign, RlsKernel, UdRls};
///
/// /// Fits `y = θ₁ + θ₂ x` and says how well it knows the slope.
/// fn line(mut kernel: impl RlsKernel<f64>, points: &[(f64, f64)]) -> ([f64; 2], f64) {
///     let (mut theta, mut variance) = ([0.0; 2], [0.0; 2]);
///     for (x, y) in points {
///         kernel.update(&[1.0, *x], *y, &mut theta);
///     }
///     kernel.variance_into(&mut variance);
///     (theta, variance[1])
/// }
///
/// let points = [(0.0, 1.0), (1.0, 3.0), (2.0, 5.0), (3.0, 7.0)];
/// let design = RlsDesign::default();
/// for (theta, variance) in [
///     line(UdRls::<f64>::new(2, &design)?, &points),
///     line(QrRls::<f64>::new(2, &design)?, &points),
/// ] {
///     assert!((theta[0] - 1.0).abs() < 1e-5 && (theta[1] - 2.0).abs() < 1e-5);
///     // 1 / Σ (x − x̄)² = 1/5, and next to nothing from the prior.
///     assert!((variance - 0.2).abs() < 1e-5);
/// }
/// # Ok::<(), fd_ident::IdentError>(())
/// ```
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
