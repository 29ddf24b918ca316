//! The samples that a difference equation looks back on.

use fd_core::{Scalar, StateVisitor};
use fd_numeric::dot;

use crate::arx::ArxOrders;

/// Past inputs and past bias values of all residual channels, newest first, so that a regressor
/// lies in memory as it is used.
#[derive(Clone, Debug)]
pub(crate) struct History<T> {
    orders: ArxOrders,
    nu: usize,
    ny: usize,
    /// `u(k), u(k−1), …` back to the oldest that is needed, `nu` values each.
    u: Vec<T>,
    /// `−μ(k−1) … −μ(k−na)` of channel 0, then of channel 1, …
    minus_mu: Vec<T>,
    /// Samples seen, counted up to the lag.
    seen: u64,
}

impl<T: Scalar> History<T> {
    pub(crate) fn new(orders: ArxOrders, nu: usize, ny: usize) -> Self {
        let inputs = if orders.nb == 0 { 0 } else { (orders.delay + orders.nb) * nu };
        let (u, minus_mu) = (vec![T::zero(); inputs], vec![T::zero(); orders.na * ny]);
        Self { orders, nu, ny, u, minus_mu, seen: 0 }
    }

    pub(crate) fn orders(&self) -> ArxOrders {
        self.orders
    }

    pub(crate) fn nu(&self) -> usize {
        self.nu
    }

    pub(crate) fn ny(&self) -> usize {
        self.ny
    }

    /// Begins sample `k` with its input.
    pub(crate) fn push_input(&mut self, u: &[T]) {
        shift_in(&mut self.u, u);
    }

    /// Ends sample `k` with its bias in every channel.
    pub(crate) fn push_bias(&mut self, mu: &[T]) {
        let na = self.orders.na;
        if na > 0 {
            for (past, &mu) in self.minus_mu.chunks_exact_mut(na).zip(mu) {
                shift_in(past, &[-mu]);
            }
        }
        self.seen = self.seen.saturating_add(1).min(self.orders.lag() as u64);
    }

    /// Whether the past that the equation needs at the present sample has been seen.
    pub(crate) fn is_full(&self) -> bool {
        self.seen == self.orders.lag() as u64
    }

    /// `φᵀ(k) θ` of one channel, where `theta` are the parameters of that channel.
    pub(crate) fn bias(&self, channel: usize, theta: &[T]) -> T {
        let na = self.orders.na;
        let (a, rest) = theta.split_at(na);
        let (b, offset) = rest.split_at(self.orders.nb * self.nu);
        let past = dot(a, &self.minus_mu[channel * na..(channel + 1) * na]);
        offset.iter().fold(past + dot(b, self.input_part()), |sum, &c| sum + c)
    }

    /// Writes `φ(k)` of one channel.
    pub(crate) fn regressor_into(&self, channel: usize, phi: &mut [T]) {
        let na = self.orders.na;
        let (past, rest) = phi.split_at_mut(na);
        past.copy_from_slice(&self.minus_mu[channel * na..(channel + 1) * na]);
        let (inputs, offset) = rest.split_at_mut(self.orders.nb * self.nu);
        inputs.copy_from_slice(self.input_part());
        offset.fill(T::one());
    }

    pub(crate) fn clear(&mut self) {
        self.u.fill(T::zero());
        self.minus_mu.fill(T::zero());
        self.seen = 0;
    }

    pub(crate) fn visit(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("past inputs", &mut self.u);
        visitor.reals("past bias, negated", &mut self.minus_mu);
        let mut counts = [self.seen];
        visitor.counts("samples seen", &mut counts);
        [self.seen] = counts;
    }

    fn input_part(&self) -> &[T] {
        if self.orders.nb == 0 { &[] } else { &self.u[self.orders.delay * self.nu..] }
    }
}

/// Moves the values back by the length of `newest` and puts that in front.
fn shift_in<T: Copy>(values: &mut [T], newest: &[T]) {
    if newest.len() <= values.len() {
        values.copy_within(..values.len() - newest.len(), newest.len());
        values[..newest.len()].copy_from_slice(newest);
    }
}
