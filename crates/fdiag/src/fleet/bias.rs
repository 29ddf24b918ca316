//! The bias models of a part, `μ̂(k) = φᵀ(k) θ` (eq. 16), row by row over its units.

use fd_core::{Scalar, StateVisitor};
use fd_ident::arx::ArxOrders;

use super::block::PART;

/// What [`ArxSimulator`](crate::ident::arx::ArxSimulator) remembers of one unit, for all of them:
/// each row holds the same number of every unit.
#[derive(Clone, Debug)]
pub(super) struct BiasRows<T> {
    orders: ArxOrders,
    nu: usize,
    /// For each channel `[a₁ … a_na; b₀ …; c]`.
    theta: Vec<T>,
    /// Inputs, newest first.
    inputs: Vec<T>,
    /// For each channel `−μ(k−1) … −μ(k−na)`.
    minus_mu: Vec<T>,
    mu_hat: Vec<T>,
}

impl<T: Scalar> BiasRows<T> {
    pub(super) fn new(orders: ArxOrders, nu: usize, channels: usize) -> Self {
        let rows = |count: usize| vec![T::zero(); count * PART];
        let inputs = if orders.nb == 0 { 0 } else { (orders.delay + orders.nb) * nu };
        Self {
            orders,
            nu,
            theta: rows(orders.parameters(nu) * channels),
            inputs: rows(inputs),
            minus_mu: rows(orders.na * channels),
            mu_hat: rows(channels),
        }
    }

    /// Parameters per channel.
    fn parameters(&self) -> usize {
        self.orders.parameters(self.nu)
    }

    /// Begins a sample with the rows of its inputs and computes `μ̂`, a row per channel.
    pub(super) fn simulate(&mut self, u: &[T]) -> &[T] {
        shift_in(&mut self.inputs, u);
        let ArxOrders { na, delay, .. } = self.orders;
        let n = self.parameters();
        for (channel, mu_hat) in self.mu_hat.chunks_exact_mut(PART).enumerate() {
            mu_hat.fill(T::zero());
            let theta = self.theta[channel * n * PART..][..n * PART].chunks_exact(PART);
            let past = self.minus_mu[channel * na * PART..][..na * PART].chunks_exact(PART);
            let inputs = self.inputs.chunks_exact(PART).skip(delay * self.nu);
            for (theta, phi) in theta.clone().zip(past.chain(inputs)) {
                for ((mu, &theta), &phi) in mu_hat.iter_mut().zip(theta).zip(phi) {
                    *mu += theta * phi;
                }
            }
            if self.orders.offset
                && let Some(constant) = theta.last()
            {
                mu_hat.iter_mut().zip(constant).for_each(|(mu, &constant)| *mu += constant);
            }
        }
        &self.mu_hat
    }

    /// Ends the sample with the bias of one channel.
    pub(super) fn push(&mut self, channel: usize, mu: &[T; PART]) {
        let na = self.orders.na;
        let past = &mut self.minus_mu[channel * na * PART..][..na * PART];
        shift_in(past, mu);
        past.iter_mut().take(PART).for_each(|mu| *mu = -*mu);
    }

    /// Freezes the parameters of one unit and channel.
    pub(super) fn load(&mut self, unit: usize, channel: usize, theta: &[T]) {
        let rows = self.theta.chunks_exact_mut(PART).skip(channel * theta.len());
        for (row, &theta) in rows.zip(theta) {
            row[unit] = theta;
        }
    }

    /// Parameters of one unit, channel by channel.
    pub(super) fn theta(&self, unit: usize) -> impl Iterator<Item = T> {
        self.theta.chunks_exact(PART).map(move |row| row[unit])
    }

    pub(super) fn reset(&mut self) {
        for rows in [&mut self.theta, &mut self.inputs, &mut self.minus_mu, &mut self.mu_hat] {
            rows.fill(T::zero());
        }
    }

    pub(super) fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("bias parameters", &mut self.theta);
        visitor.reals("bias inputs", &mut self.inputs);
        visitor.reals("bias past", &mut self.minus_mu);
    }
}

/// Puts new rows before the others; the oldest drop out.
fn shift_in<T: Copy>(rows: &mut [T], newest: &[T]) {
    if rows.len() >= newest.len() {
        let kept = rows.len() - newest.len();
        rows.copy_within(..kept, newest.len());
        rows[..newest.len()].copy_from_slice(newest);
    }
}
