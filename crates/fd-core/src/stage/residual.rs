//! From samples to residuals.

use crate::{dims::IoDims, frame::Frame, scalar::Scalar, stage::Stage};

/// A signal that is near zero while the plant behaves as modelled.
pub trait ResidualGenerator<T: Scalar = f64>: Stage<T> {
    /// Channels of the frames this generator accepts.
    fn io(&self) -> IoDims;

    /// Number of residual channels.
    fn residual_len(&self) -> usize;

    /// Consumes one sample and writes the residual into `r`.
    fn step(&mut self, frame: Frame<'_, T>, r: &mut [T]);
}
