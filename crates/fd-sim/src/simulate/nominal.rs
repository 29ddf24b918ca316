//! What is diagnosed: a simulator, and a model that effects can be spliced into.

use fd_model::SampleTime;

use super::{EquationSimulator, SimulateError, Simulator};
use crate::{model::Model, scales::ReplayScales};

/// A simulator as its user brings it, with a model that effects can be spliced into.
///
/// For equations the two are the same. A black box lends its inputs, outputs, exposed parameters
/// and force ports to a shell of equations around it; effects are spliced into the shell.
pub trait Nominal: std::fmt::Debug + Send + Sync {
    /// The model that effects are spliced into; its outputs carry the stated noise.
    fn model(&self) -> &Model;

    /// A simulator of the model with effects spliced in. Its parameters are those of the patched
    /// model, in that order.
    ///
    /// # Errors
    ///
    /// Returns an error when the patched model cannot be simulated with samples `ts` apart.
    fn patched(&self, model: &Model, ts: SampleTime) -> Result<Box<dyn Simulator>, SimulateError>;

    /// A simulator without any effect.
    ///
    /// # Errors
    ///
    /// As [`patched`](Self::patched).
    fn simulator(&self, ts: SampleTime) -> Result<Box<dyn Simulator>, SimulateError> {
        self.patched(self.model(), ts)
    }

    /// Sizes of all signals of the model in a simulation without any effect.
    ///
    /// # Errors
    ///
    /// As [`ReplayScales::of`].
    fn scales(
        &self,
        ts: SampleTime,
        u: &[f64],
        samples: usize,
    ) -> Result<ReplayScales, SimulateError> {
        ReplayScales::of(self.model(), ts, u, samples)
    }
}

impl Nominal for Model {
    fn model(&self) -> &Model {
        self
    }

    fn patched(&self, model: &Model, ts: SampleTime) -> Result<Box<dyn Simulator>, SimulateError> {
        Ok(Box::new(EquationSimulator::<f64>::at(model, ts)?))
    }
}
