//! Scheduled models learned sample by sample, one region at a time.

use fd_core::{
    Scalar, StateVisitor,
    stage::{GuardReport, Identifier, Stage},
};

use super::{Regions, Scheduler};
use crate::{
    arx::{ArxOrders, History},
    error::IdentError,
    rls::{RlsKernel, UdRls, check_parameters},
};

/// One recursive estimator per region and residual channel; only the nearest region learns.
///
/// [`Identifier::retrain`] keeps the parameters of all regions, and lets a region forget its own
/// when it learns its first sample afterwards.
///
/// # Examples
///
/// ```
/// use fd_core::stage::Identifier;
/// use fd_ident::{
///     arx::ArxOrders,
///     rls::{RlsDesign, UdRls},
///     scheduled::{RecursiveScheduled, Regions},
/// };
///
/// let orders = ArxOrders::new(1, 1, 0).with_offset();
/// let kernel = UdRls::<f64>::new(orders.parameters(1), &RlsDesign::default())?;
/// let regions = Regions::new(0, 0.0, vec![-1.0, 1.0])?;
/// let mut identifier = RecursiveScheduled::new(&regions, orders, 1, 1, kernel)?;
/// (0..9).for_each(|_| identifier.update(&[2.0], &[5.0]));
/// let (low, high) = identifier.theta().split_at(3);
/// assert!(low.iter().all(|v| *v == 0.0) && high.iter().any(|v| *v != 0.0));
/// # Ok::<(), fd_ident::IdentError>(())
/// ```
#[derive(Clone, Debug)]
pub struct RecursiveScheduled<T: Scalar = f64, K = UdRls<T>> {
    scheduler: Scheduler<T>,
    history: History<T>,
    /// Residual channel by residual channel, in each region by region, as the parameters.
    kernels: Vec<K>,
    theta: Vec<T>,
    phi: Vec<T>,
    /// 1 for a region that has yet to forget what it knew before a re-training.
    stale: Vec<u64>,
}

impl<T: Scalar, K: RlsKernel<T>> RecursiveScheduled<T, K> {
    /// An identifier for `nu` inputs and `residual_len` residual channels; each region of each
    /// channel gets a copy of `kernel`.
    ///
    /// # Errors
    ///
    /// Returns an error when the orders leave no parameters, `kernel` has another number, or the
    /// scheduling input does not exist.
    pub fn new(
        regions: &Regions,
        orders: ArxOrders,
        nu: usize,
        residual_len: usize,
        kernel: K,
    ) -> Result<Self, IdentError> {
        let n = orders.checked_parameters(nu)?;
        check_parameters(&kernel, n)?;
        if regions.input() >= nu {
            let (setting, expected) = ("scheduling input", "below the number of inputs");
            let found = regions.input() as f64;
            return Err(IdentError::Setting { setting, expected, found });
        }
        let count = regions.len() * residual_len;
        Ok(Self {
            scheduler: regions.freeze(),
            history: History::new(orders, nu, residual_len),
            kernels: vec![kernel; count],
            theta: vec![T::zero(); n * count],
            phi: vec![T::zero(); n],
            stale: vec![0; regions.len()],
        })
    }
}

impl<T: Scalar, K: RlsKernel<T>> Identifier<T> for RecursiveScheduled<T, K> {
    fn nu(&self) -> usize {
        self.history.nu()
    }

    fn residual_len(&self) -> usize {
        self.history.ny()
    }

    fn update(&mut self, u: &[T], mu: &[T]) {
        self.history.push_input(u);
        self.scheduler.step(u);
        if self.history.is_full() {
            let (n, regions) = (self.phi.len(), self.stale.len());
            let region = self.scheduler.nearest();
            for (channel, &mu) in mu.iter().enumerate() {
                let place = channel * regions + region;
                let theta = &mut self.theta[place * n..(place + 1) * n];
                let kernel = &mut self.kernels[place];
                if self.stale[region] == 1 {
                    kernel.reset();
                    theta.fill(T::zero());
                }
                self.history.regressor_into(channel, &mut self.phi);
                kernel.update(&self.phi, mu, theta);
            }
            self.stale[region] = 0;
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

    fn retrain(&mut self, theta: &[T]) -> bool {
        self.theta.copy_from_slice(theta);
        self.stale.fill(1);
        self.history.clear();
        self.scheduler.reset();
        true
    }
}

impl<T: Scalar, K: RlsKernel<T>> Stage<T> for RecursiveScheduled<T, K> {
    fn reset(&mut self) {
        self.scheduler.reset();
        self.history.clear();
        self.kernels.iter_mut().for_each(Stage::reset);
        self.theta.fill(T::zero());
        self.stale.fill(0);
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        self.scheduler.visit_state(visitor);
        self.history.visit(visitor);
        for kernel in &mut self.kernels {
            kernel.visit_state(visitor);
        }
        visitor.reals("parameters theta", &mut self.theta);
        visitor.counts("stale regions", &mut self.stale);
    }
}
