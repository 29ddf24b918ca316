//! Difference equations at run time.

use fd_core::{
    Scalar, StateVisitor,
    stage::{BiasModel, Stage},
};

use crate::{
    arx::{ArxOrders, history::History},
    error::IdentError,
};

/// A bias model `μ̂(k) = φᵀ(k) θ`, eq. (16), for any number of inputs and residual channels.
///
/// *Simulation* puts its own past `μ̂` into `φ`, *prediction* the measured past. Before the first
/// sample everything is zero, unless [`BiasModel::observe`] showed it the past.
///
/// # Examples
///
/// `μ(k) = 0.5 μ(k−1) + u(k)`:
///
/// ```
/// use fd_core::stage::BiasModel;
/// use fd_ident::arx::{ArxOrders, ArxSimulator};
///
/// let mut bias = ArxSimulator::<f64>::new(ArxOrders::new(1, 1, 0), 1, 1)?;
/// bias.load(&[-0.5, 1.0]);
/// let mut mu_hat = [0.0];
/// bias.simulate(&[1.0], &mut mu_hat);
/// bias.simulate(&[1.0], &mut mu_hat);
/// assert_eq!(mu_hat, [1.5]);
/// # Ok::<(), fd_ident::IdentError>(())
/// ```
#[derive(Clone, Debug)]
pub struct ArxSimulator<T: Scalar = f64> {
    history: History<T>,
    theta: Vec<T>,
    /// Parameters that it was built with, to which a reset goes back.
    built: Vec<T>,
}

impl<T: Scalar> ArxSimulator<T> {
    /// A model whose parameters are zero until some are loaded.
    ///
    /// # Errors
    ///
    /// Returns an error when the orders leave no parameters.
    pub fn new(orders: ArxOrders, nu: usize, residual_len: usize) -> Result<Self, IdentError> {
        let theta = vec![T::zero(); orders.checked_parameters(nu)? * residual_len];
        Ok(Self { history: History::new(orders, nu, residual_len), built: theta.clone(), theta })
    }

    /// The parameters in use, those of residual channel 0 first.
    #[must_use]
    pub fn theta(&self) -> &[T] {
        &self.theta
    }

    /// Makes the present parameters those that a reset goes back to.
    #[must_use]
    pub(crate) fn keeping_parameters(mut self) -> Self {
        self.built.copy_from_slice(&self.theta);
        self
    }

    fn compute(&mut self, u: &[T], mu_hat: &mut [T]) {
        self.history.push_input(u);
        let n = self.history.orders().parameters(self.history.nu());
        for (channel, (theta, mu_hat)) in self.theta.chunks_exact(n).zip(mu_hat).enumerate() {
            *mu_hat = self.history.bias(channel, theta);
        }
    }
}

impl<T: Scalar> BiasModel<T> for ArxSimulator<T> {
    fn nu(&self) -> usize {
        self.history.nu()
    }

    fn residual_len(&self) -> usize {
        self.history.ny()
    }

    fn theta_len(&self) -> usize {
        self.theta.len()
    }

    /// # Panics
    ///
    /// Panics when `theta` is not [`BiasModel::theta_len`] long, as copying a slice does.
    fn load(&mut self, theta: &[T]) {
        self.theta.copy_from_slice(theta);
    }

    fn observe(&mut self, u: &[T], mu: &[T]) {
        self.history.push_input(u);
        self.history.push_bias(mu);
    }

    fn simulate(&mut self, u: &[T], mu_hat: &mut [T]) {
        self.compute(u, mu_hat);
        self.history.push_bias(mu_hat);
    }

    fn predict(&mut self, u: &[T], r: &[T], mu_hat: &mut [T]) {
        self.compute(u, mu_hat);
        self.history.push_bias(r);
    }
}

/// Loaded parameters are memory: a reset goes back to those that the model was built with.
impl<T: Scalar> Stage<T> for ArxSimulator<T> {
    fn reset(&mut self) {
        self.history.clear();
        self.theta.copy_from_slice(&self.built);
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        self.history.visit(visitor);
        visitor.reals("parameters theta", &mut self.theta);
    }
}
