//! Bias models in state-space form at run time.

use fd_core::{
    Heap, HeapMap, IoDims, LinMap, Scalar, StateVisitor,
    stage::{BiasModel, Plant, Stage},
};
use fd_model::{Lti, freeze};

use super::StateSpaceBias;
use crate::error::IdentError;

/// A bias model in state-space form, made by [`StateSpaceBias::freeze`].
///
/// Its parameters are constants of the design: there is nothing to load, and
/// [`BiasModel::theta_len`] is 0. *Prediction* is one step of the observer that also finds the
/// state from an observed bias.
#[derive(Clone, Debug)]
pub struct StateSpaceSimulator<T: Scalar = f64> {
    system: Lti<T, Heap>,
    gain: HeapMap<T>,
    offset: Vec<T>,
    x: Vec<T>,
    next: Vec<T>,
    /// Error of the observed bias, and room for what was expected.
    error: Vec<T>,
    mu_hat: Vec<T>,
}

impl StateSpaceBias {
    /// Moves the model to run time.
    ///
    /// # Errors
    ///
    /// Never fails for a model that was checked by [`StateSpaceBias::new`].
    pub fn freeze<T: Scalar>(&self) -> Result<StateSpaceSimulator<T>, IdentError> {
        StateSpaceSimulator::new(self)
    }
}

impl<T: Scalar> StateSpaceSimulator<T> {
    pub(super) fn new(model: &StateSpaceBias) -> Result<Self, IdentError> {
        let system: Lti<T, Heap> = model.system().freeze()?;
        let gain = freeze("gain of the bias observer", model.gain().as_ref())?;
        let zeros = vec![T::zero(); system.nx()];
        Ok(Self {
            offset: model.offset().iter().map(|&c| T::from_design(c)).collect(),
            error: vec![T::zero(); system.io().ny],
            mu_hat: vec![T::zero(); system.io().ny],
            x: zeros.clone(),
            next: zeros,
            system,
            gain,
        })
    }

    /// Writes the output and computes the next state without any correction.
    fn advance(&mut self, u: &[T], mu_hat: &mut [T]) {
        self.system.output(&self.x, u, mu_hat);
        for (mu, &offset) in mu_hat.iter_mut().zip(&self.offset) {
            *mu += offset;
        }
        self.system.advance(&self.x, u, &mut self.next);
    }

    fn correct(&mut self, mu: &[T], mu_hat: &[T]) {
        for ((error, &mu), &mu_hat) in self.error.iter_mut().zip(mu).zip(mu_hat) {
            *error = mu - mu_hat;
        }
        self.gain.mul_add_into(&self.error, &mut self.next);
        self.x.copy_from_slice(&self.next);
    }
}

impl<T: Scalar> BiasModel<T> for StateSpaceSimulator<T> {
    fn nu(&self) -> usize {
        let IoDims { nu, .. } = self.system.io();
        nu
    }

    fn residual_len(&self) -> usize {
        self.offset.len()
    }

    fn theta_len(&self) -> usize {
        0
    }

    fn load(&mut self, _theta: &[T]) {}

    fn observe(&mut self, u: &[T], mu: &[T]) {
        let mut mu_hat = std::mem::take(&mut self.mu_hat);
        self.predict(u, mu, &mut mu_hat);
        self.mu_hat = mu_hat;
    }

    fn simulate(&mut self, u: &[T], mu_hat: &mut [T]) {
        self.advance(u, mu_hat);
        self.x.copy_from_slice(&self.next);
    }

    fn predict(&mut self, u: &[T], r: &[T], mu_hat: &mut [T]) {
        self.advance(u, mu_hat);
        self.correct(r, mu_hat);
    }
}

impl<T: Scalar> Stage<T> for StateSpaceSimulator<T> {
    fn reset(&mut self) {
        self.x.fill(T::zero());
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("bias state", &mut self.x);
    }
}
