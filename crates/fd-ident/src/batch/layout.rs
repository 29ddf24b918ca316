//! Where the rows of a tile are, and where regressors come from.

use crate::arx::ArxOrders;

/// Where the rows of a tile are: settings first, then what it remembers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    pub n: usize,
    pub regressors: Regressors,
}

/// Where regressors come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Regressors {
    /// From the samples.
    Given,
    /// From the past of `nu` inputs and a bias, which the tile remembers.
    Past { orders: ArxOrders, nu: usize },
}

impl Regressors {
    /// Past inputs, newest first, and past values of the negated bias.
    pub(super) const fn past(self) -> (usize, usize) {
        match self {
            Self::Given => (0, 0),
            Self::Past { orders: ArxOrders { nb: 0, na, .. }, .. } => (0, na),
            Self::Past { orders, nu } => ((orders.delay + orders.nb) * nu, orders.na),
        }
    }
}

impl Layout {
    /// Most parameters.
    pub(super) const LARGEST: usize = 64;
    /// Most rows of the past.
    pub(super) const LONGEST: usize = 32;

    pub(super) const NOISE: usize = 0;
    pub(super) const MINUS_SCALE: usize = 1;
    pub(super) const SILENCE: usize = 2;
    pub(super) const GROWTH: usize = 3;
    pub(super) const LARGEST_TRACE: usize = 4;
    pub(super) const KEPT: usize = 5;
    pub(super) const TRACE_BOUND: usize = 6;
    pub(super) const D: usize = 7;

    pub(super) const fn theta(self) -> usize {
        Self::D + self.n
    }

    /// Entry `(i, j)` of `U`, `i < j`: columns packed one after the other.
    pub(super) const fn u(self, i: usize, j: usize) -> usize {
        self.theta() + self.n + j * (j - 1) / 2 + i
    }

    /// First row of the past: inputs, newest first, then the negated bias, newest first.
    pub(super) const fn past(self) -> usize {
        Self::D + 2 * self.n + self.n * (self.n - 1) / 2
    }

    /// Rows of one tile.
    pub(super) const fn rows(self) -> usize {
        let (inputs, bias) = self.regressors.past();
        self.past() + inputs + bias
    }

    /// Rows of one sample besides the target.
    pub(super) const fn columns(self) -> usize {
        match self.regressors {
            Regressors::Given => self.n,
            Regressors::Past { nu, .. } => nu,
        }
    }
}
