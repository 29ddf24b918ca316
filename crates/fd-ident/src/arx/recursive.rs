//! Difference equations learned sample by sample.

use fd_core::{
    Scalar, StateVisitor,
    stage::{GuardReport, Identifier, Stage},
};

use crate::{
    arx::{ArxOrders, history::History},
    error::IdentError,
    rls::{RlsKernel, UdRls, check_parameters},
};

/// One recursive estimator per residual channel, all with the same orders.
///
/// The regressor is that of eq. (15): measured bias and input. Learning starts when the whole
/// past that the equation looks back on has been seen, so that the result equals that of a batch
/// fit over the same samples.
///
/// # Examples
///
/// The paper's order 2 for one input and one residual:
///
/// ```
/// use fd_core::stage::Identifier;
/// use fd_ident::{arx::{ArxOrders, RecursiveArx}, rls::{RlsDesign, UdRls}};
///
/// let orders = ArxOrders::paper(2);
/// let kernel = UdRls::<f64>::new(orders.parameters(1), &RlsDesign::default())?;
/// let mut identifier = RecursiveArx::new(orders, 1, 1, kernel)?;
/// identifier.update(&[1.0], &[0.0]);
/// assert_eq!(identifier.theta().len(), 5);
/// # Ok::<(), fd_ident::IdentError>(())
/// ```
#[derive(Clone, Debug)]
pub struct RecursiveArx<T: Scalar = f64, K = UdRls<T>> {
    history: History<T>,
    kernels: Vec<K>,
    theta: Vec<T>,
    phi: Vec<T>,
}

impl<T: Scalar, K: RlsKernel<T>> RecursiveArx<T, K> {
    /// An identifier for `nu` inputs and `residual_len` residual channels; each channel gets a
    /// copy of `kernel`.
    ///
    /// # Errors
    ///
    /// Returns an error when the orders leave no parameters, or `kernel` has another number of
    /// parameters than the orders.
    pub fn new(
        orders: ArxOrders,
        nu: usize,
        residual_len: usize,
        kernel: K,
    ) -> Result<Self, IdentError> {
        let n = orders.checked_parameters(nu)?;
        check_parameters(&kernel, n)?;
        Ok(Self {
            history: History::new(orders, nu, residual_len),
            kernels: vec![kernel; residual_len],
            theta: vec![T::zero(); n * residual_len],
            phi: vec![T::zero(); n],
        })
    }

    /// The orders of every channel.
    #[must_use]
    pub fn orders(&self) -> ArxOrders {
        self.history.orders()
    }
}

impl<T: Scalar, K: RlsKernel<T>> Identifier<T> for RecursiveArx<T, K> {
    fn nu(&self) -> usize {
        self.history.nu()
    }

    fn residual_len(&self) -> usize {
        self.history.ny()
    }

    fn update(&mut self, u: &[T], mu: &[T]) {
        self.history.push_input(u);
        if self.history.is_full() {
            let thetas = self.theta.chunks_exact_mut(self.phi.len());
            for (channel, (kernel, theta)) in self.kernels.iter_mut().zip(thetas).enumerate() {
                self.history.regressor_into(channel, &mut self.phi);
                kernel.update(&self.phi, mu[channel], theta);
            }
        }
        self.history.push_bias(mu);
    }

    fn theta(&self) -> &[T] {
        &self.theta
    }

    fn variance_into(&self, variance: &mut [T]) {
        let variances = variance.chunks_exact_mut(self.phi.len());
        for (kernel, variance) in self.kernels.iter().zip(variances) {
            kernel.variance_into(variance);
        }
    }

    fn guard(&self) -> GuardReport {
        self.kernels.iter().map(K::guard).sum()
    }
}

impl<T: Scalar, K: RlsKernel<T>> Stage<T> for RecursiveArx<T, K> {
    fn reset(&mut self) {
        self.history.clear();
        self.kernels.iter_mut().for_each(Stage::reset);
        self.theta.fill(T::zero());
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        self.history.visit(visitor);
        for kernel in &mut self.kernels {
            kernel.visit_state(visitor);
        }
        visitor.reals("parameters theta", &mut self.theta);
    }
}
