//! Extended least squares sample by sample.

use fd_core::{
    Scalar, StateVisitor,
    stage::{GuardReport, Identifier, Stage},
};
use fd_numeric::dot;

use crate::{
    arx::{ArxOrders, History},
    error::IdentError,
    rls::{RlsKernel, UdRls, check_parameters},
};

/// Recursive extended least squares, one estimator per residual channel, see the
/// [module](super).
///
/// [`Identifier::theta`] shows the parameters of the bias model alone, so that it fits any
/// [`ArxSimulator`](crate::arx::ArxSimulator); those of the noise are at
/// [`RecursiveArmax::noise`].
///
/// # Examples
///
/// ```
/// use fd_core::stage::Identifier;
/// use fd_ident::{arx::ArxOrders, extended::RecursiveArmax, rls::{RlsDesign, UdRls}};
///
/// let orders = ArxOrders::paper(2);
/// let kernel = UdRls::<f64>::new(orders.parameters(1) + 2, &RlsDesign::default())?;
/// let identifier = RecursiveArmax::new(orders, 2, 1, 1, kernel)?;
/// assert_eq!((identifier.theta().len(), identifier.noise(0).len()), (5, 2));
/// # Ok::<(), fd_ident::IdentError>(())
/// ```
#[derive(Clone, Debug)]
pub struct RecursiveArmax<T: Scalar = f64, K = UdRls<T>> {
    history: History<T>,
    kernels: Vec<K>,
    /// `[a, b, offset, c]` of each channel.
    extended: Vec<T>,
    /// `[a, b, offset]` of each channel.
    theta: Vec<T>,
    /// `ε(k−1) … ε(k−nc)` of each channel.
    errors: Vec<T>,
    nc: usize,
    phi: Vec<T>,
    /// Variances of `extended`; kept, because a kernel writes those of the noise along.
    variances: Vec<T>,
}

impl<T: Scalar, K: RlsKernel<T>> RecursiveArmax<T, K> {
    /// An identifier with `nc` coefficients of the noise; each channel gets a copy of `kernel`,
    /// which has that many parameters more than the orders.
    ///
    /// # Errors
    ///
    /// Returns an error when the orders leave no parameters, or `kernel` has another number.
    pub fn new(
        orders: ArxOrders,
        nc: usize,
        nu: usize,
        residual_len: usize,
        kernel: K,
    ) -> Result<Self, IdentError> {
        let n = orders.checked_parameters(nu)?;
        check_parameters(&kernel, n + nc)?;
        let zeros = |len: usize| vec![T::zero(); len];
        Ok(Self {
            history: History::new(orders, nu, residual_len),
            kernels: vec![kernel; residual_len],
            extended: zeros((n + nc) * residual_len),
            theta: zeros(n * residual_len),
            errors: zeros(nc * residual_len),
            nc,
            phi: zeros(n + nc),
            variances: zeros((n + nc) * residual_len),
        }
        .with_prior_variances())
    }

    fn with_prior_variances(mut self) -> Self {
        self.read_variances();
        self
    }

    fn read_variances(&mut self) {
        let width = self.phi.len();
        for (kernel, all) in self.kernels.iter().zip(self.variances.chunks_exact_mut(width)) {
            kernel.variance_into(all);
        }
    }

    /// `c₁ … c_nc` of one residual channel.
    ///
    /// # Panics
    ///
    /// Panics when there is no such channel, as indexing a slice does.
    #[must_use]
    pub fn noise(&self, channel: usize) -> &[T] {
        let width = self.phi.len();
        &self.extended[(channel + 1) * width - self.nc..(channel + 1) * width]
    }
}

impl<T: Scalar, K: RlsKernel<T>> Identifier<T> for RecursiveArmax<T, K> {
    fn nu(&self) -> usize {
        self.history.nu()
    }

    fn residual_len(&self) -> usize {
        self.history.ny()
    }

    fn update(&mut self, u: &[T], mu: &[T]) {
        self.history.push_input(u);
        if self.history.is_full() {
            let (width, nc) = (self.phi.len(), self.nc);
            let n = width - nc;
            for (channel, kernel) in self.kernels.iter_mut().enumerate() {
                let errors = &mut self.errors[channel * nc..(channel + 1) * nc];
                self.history.regressor_into(channel, &mut self.phi[..n]);
                self.phi[n..].copy_from_slice(errors);
                let extended = &mut self.extended[channel * width..(channel + 1) * width];
                kernel.update(&self.phi, mu[channel], extended);
                // A posteriori, with the parameters that already know this sample.
                let error = mu[channel] - dot(&self.phi, extended);
                if nc > 0 {
                    errors.rotate_right(1);
                    errors[0] = if error.is_finite() { error } else { T::zero() };
                }
                self.theta[channel * n..(channel + 1) * n].copy_from_slice(&extended[..n]);
            }
            self.read_variances();
        }
        self.history.push_bias(mu);
    }

    fn theta(&self) -> &[T] {
        &self.theta
    }

    fn variance_into(&self, variance: &mut [T]) {
        let width = self.phi.len();
        let n = width - self.nc;
        let channels = self.variances.chunks_exact(width).zip(variance.chunks_exact_mut(n));
        for (all, variance) in channels {
            variance.copy_from_slice(&all[..n]);
        }
    }

    fn guard(&self) -> GuardReport {
        self.kernels.iter().map(K::guard).sum()
    }
}

impl<T: Scalar, K: RlsKernel<T>> Stage<T> for RecursiveArmax<T, K> {
    fn reset(&mut self) {
        self.history.clear();
        self.kernels.iter_mut().for_each(Stage::reset);
        for values in [&mut self.extended, &mut self.theta, &mut self.errors] {
            values.fill(T::zero());
        }
        self.read_variances();
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        self.history.visit(visitor);
        for kernel in &mut self.kernels {
            kernel.visit_state(visitor);
        }
        visitor.reals("parameters with noise", &mut self.extended);
        visitor.reals("parameters theta", &mut self.theta);
        visitor.reals("past errors", &mut self.errors);
        visitor.reals("variances with noise", &mut self.variances);
    }
}
