//! The identifier that never learns, for bias models that were fitted beforehand.

use fd_core::{
    Scalar, StateVisitor,
    stage::{GuardReport, Identifier, Stage},
};

/// Parameters that stay as they are.
///
/// With a pre-fitted compensator it stands where a recursive estimator would stand, when no
/// re-training is wanted.
#[derive(Clone, Debug, PartialEq)]
pub struct FixedParameters<T> {
    nu: usize,
    residual_len: usize,
    theta: Vec<T>,
}

impl<T: Scalar> FixedParameters<T> {
    /// Parameters for `nu` inputs and `residual_len` residual channels.
    ///
    /// ```
    /// use fd_compensate::residual_compensation::FixedParameters;
    /// use fd_core::stage::Identifier;
    ///
    /// assert_eq!(FixedParameters::<f64>::new(1, 1, &[-0.3]).theta(), [-0.3]);
    /// ```
    #[must_use]
    pub fn new(nu: usize, residual_len: usize, theta: &[f64]) -> Self {
        Self { nu, residual_len, theta: theta.iter().map(|&v| T::from_design(v)).collect() }
    }
}

impl<T: Scalar> Stage<T> for FixedParameters<T> {
    fn reset(&mut self) {}

    fn visit_state(&mut self, _visitor: &mut dyn StateVisitor<T>) {}
}

impl<T: Scalar> Identifier<T> for FixedParameters<T> {
    fn nu(&self) -> usize {
        self.nu
    }

    fn residual_len(&self) -> usize {
        self.residual_len
    }

    fn update(&mut self, _u: &[T], _mu: &[T]) {}

    fn theta(&self) -> &[T] {
        &self.theta
    }

    fn variance_into(&self, variance: &mut [T]) {
        variance.fill(T::zero());
    }

    fn guard(&self) -> GuardReport {
        GuardReport::default()
    }
}
