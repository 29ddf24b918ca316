//! The past samples from which regressors of a difference equation are built, in the lanes of a register.
#![expect(
    clippy::inline_always,
    reason = "what is not inlined into code for wide registers is compiled for narrow ones"
)]

use fd_numeric::lanes::Aligned;

use super::layout::{Layout, Regressors};

/// Past inputs and past values of the negated bias, newest first, as in
/// [`RecursiveArx`](crate::arx::RecursiveArx).
pub(super) struct Past<R> {
    rows: Aligned<[R; Layout::LONGEST]>,
    /// Rows of inputs, of inputs that are too young, and of the bias.
    inputs: usize,
    waiting: usize,
    bias: usize,
}

impl<R: Copy> Past<R> {
    #[inline(always)]
    pub(super) fn new(zero: R, layout: Layout) -> Self {
        let rows = Aligned([zero; Layout::LONGEST]);
        match layout.regressors {
            Regressors::Given => Self { rows, inputs: 0, waiting: 0, bias: 0 },
            Regressors::Past { orders, nu } => {
                let (inputs, bias) = layout.regressors.past();
                let waiting = if inputs == 0 { 0 } else { orders.delay * nu };
                Self { rows, inputs, waiting, bias }
            }
        }
    }

    /// All rows, in the order in which a tile has them.
    #[inline(always)]
    pub(super) fn rows(&mut self) -> impl Iterator<Item = &mut R> {
        self.rows[..self.inputs + self.bias].iter_mut()
    }

    /// Begins a sample.
    #[inline(always)]
    pub(super) fn push_input(&mut self, nu: usize, input: impl Fn(usize) -> R) {
        if self.inputs == 0 {
            return;
        }
        for i in (nu..self.inputs).rev() {
            self.rows[i] = self.rows[i - nu];
        }
        for i in 0..nu {
            self.rows[i] = input(i);
        }
    }

    /// `φ = [−μ(k−1) …; u(k−d) …; 1]`.
    #[inline(always)]
    pub(super) fn regressor_into(&self, phi: &mut [R], one: R) {
        let inputs = self.inputs - self.waiting;
        for (i, phi) in phi.iter_mut().enumerate() {
            *phi = if i < self.bias {
                self.rows[self.inputs + i]
            } else if i < self.bias + inputs {
                self.rows[self.waiting + i - self.bias]
            } else {
                one
            };
        }
    }

    /// Ends a sample.
    #[inline(always)]
    pub(super) fn push_bias(&mut self, minus_bias: R) {
        let newest = self.inputs;
        for i in (newest + 1..newest + self.bias).rev() {
            self.rows[i] = self.rows[i - 1];
        }
        if self.bias > 0 {
            self.rows[newest] = minus_bias;
        }
    }
}
