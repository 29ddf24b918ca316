//! From inputs and parameters to the bias of a residual.

use crate::{scalar::Scalar, stage::Stage};

/// A model of the bias `μ` that unmodelled effects leave in the residual, driven by `u`.
///
/// The four per-sample methods are alternatives: exactly one of them is called per sample, and
/// each moves the model on by one sample.
pub trait BiasModel<T: Scalar = f64>: Stage<T> {
    /// Number of inputs `u`.
    fn nu(&self) -> usize;

    /// Number of residual channels.
    fn residual_len(&self) -> usize;

    /// Number of parameters, all residual channels together.
    fn theta_len(&self) -> usize;

    /// Takes over parameters, those of residual channel 0 first.
    fn load(&mut self, theta: &[T]);

    /// Remembers a measured bias, so that a simulation can start from it without a transient.
    fn observe(&mut self, u: &[T], mu: &[T]);

    /// Simulates: computes `μ̂` from past and present inputs and its *own* past values. A fault
    /// in the residual cannot leak into it.
    fn simulate(&mut self, u: &[T], mu_hat: &mut [T]);

    /// Predicts one step: computes `μ̂` from past *measured* residuals, then remembers `r`. A
    /// fault leaks into the prediction after one sample, so this is for comparison only.
    fn predict(&mut self, u: &[T], r: &[T], mu_hat: &mut [T]);
}
