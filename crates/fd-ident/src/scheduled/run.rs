//! Scheduled models at run time.

use fd_core::{
    Scalar, StateVisitor,
    stage::{BiasModel, Stage},
};

use super::Scheduler;
use crate::arx::ArxSimulator;

/// Local models that all run, and a schedule that says how much each of them counts.
///
/// Made by [`ScheduledModel::freeze`](super::ScheduledModel::freeze). Parameters are ordered
/// residual channel by residual channel, in each region by region.
#[derive(Clone, Debug)]
pub struct ScheduledSimulator<T: Scalar = f64> {
    scheduler: Scheduler<T>,
    locals: Vec<ArxSimulator<T>>,
    /// Bias of one local model.
    local: Vec<T>,
    /// Parameters of one local model.
    theta: Vec<T>,
}

impl<T: Scalar> ScheduledSimulator<T> {
    pub(super) fn new(scheduler: Scheduler<T>, locals: Vec<ArxSimulator<T>>) -> Self {
        let (ny, n) = locals.first().map_or((0, 0), |l| (l.residual_len(), l.theta_len()));
        Self { scheduler, locals, local: vec![T::zero(); ny], theta: vec![T::zero(); n] }
    }

    fn blend(
        &mut self,
        u: &[T],
        mu_hat: &mut [T],
        mut run: impl FnMut(&mut ArxSimulator<T>, &mut [T]),
    ) {
        mu_hat.fill(T::zero());
        let weights = self.scheduler.step(u);
        for (local, &weight) in self.locals.iter_mut().zip(weights) {
            run(local, &mut self.local);
            // A silent region must stay silent even if its model has diverged.
            if weight > T::zero() {
                for (sum, &mu) in mu_hat.iter_mut().zip(&self.local) {
                    *sum += weight * mu;
                }
            }
        }
    }
}

impl<T: Scalar> BiasModel<T> for ScheduledSimulator<T> {
    fn nu(&self) -> usize {
        self.locals.first().map_or(0, BiasModel::nu)
    }

    fn residual_len(&self) -> usize {
        self.local.len()
    }

    fn theta_len(&self) -> usize {
        self.theta.len() * self.locals.len()
    }

    fn load(&mut self, theta: &[T]) {
        let regions = self.locals.len();
        let n = self.theta.len() / self.local.len().max(1);
        for (region, local) in self.locals.iter_mut().enumerate() {
            for (channel, own) in self.theta.chunks_exact_mut(n.max(1)).enumerate() {
                let start = (channel * regions + region) * n;
                own.copy_from_slice(&theta[start..start + n]);
            }
            local.load(&self.theta);
        }
    }

    fn observe(&mut self, u: &[T], mu: &[T]) {
        self.scheduler.step(u);
        self.locals.iter_mut().for_each(|local| local.observe(u, mu));
    }

    fn simulate(&mut self, u: &[T], mu_hat: &mut [T]) {
        self.blend(u, mu_hat, |local, mu| local.simulate(u, mu));
    }

    fn predict(&mut self, u: &[T], r: &[T], mu_hat: &mut [T]) {
        self.blend(u, mu_hat, |local, mu| local.predict(u, r, mu));
    }
}

impl<T: Scalar> Stage<T> for ScheduledSimulator<T> {
    fn reset(&mut self) {
        self.scheduler.reset();
        self.locals.iter_mut().for_each(Stage::reset);
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        self.scheduler.visit_state(visitor);
        for local in &mut self.locals {
            local.visit_state(visitor);
        }
    }
}
