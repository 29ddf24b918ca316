//! The trial of a candidate model against the healthy residual, before the switch opens.

use fd_core::{Scalar, StateVisitor};

use super::design::Trial;

/// Compares what a candidate leaves of the residual with the residual.
#[derive(Clone, Debug)]
pub(super) struct TrialRun<T> {
    samples: u64,
    worst_ratio: T,
    left: Vec<T>,
    whole: Vec<T>,
    seen: u64,
}

/// Where a trial stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TrialOutcome {
    Ongoing,
    Accepted,
    Rejected,
}

impl<T: Scalar> TrialRun<T> {
    pub(super) fn new(plan: &Trial, residual_len: usize) -> Self {
        Self {
            samples: plan.samples,
            worst_ratio: T::from_design(plan.worst_ratio),
            left: vec![T::zero(); residual_len],
            whole: vec![T::zero(); residual_len],
            seen: 0,
        }
    }

    /// Whether candidates are tried at all.
    pub(super) fn is_wanted(&self) -> bool {
        self.samples > 0
    }

    pub(super) fn add(&mut self, r: &[T], mu_hat: &[T]) -> TrialOutcome {
        for (((left, whole), &r), &mu) in
            self.left.iter_mut().zip(&mut self.whole).zip(r).zip(mu_hat)
        {
            *left += (r - mu) * (r - mu);
            *whole += r * r;
        }
        self.seen += 1;
        if self.seen < self.samples {
            return TrialOutcome::Ongoing;
        }
        let ratio = self.worst_ratio * self.worst_ratio;
        // A NaN fails the comparison, so that a diverged candidate is rejected.
        let fine = self.left.iter().zip(&self.whole).all(|(&left, &whole)| left <= ratio * whole);
        if fine { TrialOutcome::Accepted } else { TrialOutcome::Rejected }
    }

    pub(super) fn reset(&mut self) {
        self.left.fill(T::zero());
        self.whole.fill(T::zero());
        self.seen = 0;
    }

    pub(super) fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("trial squares left", &mut self.left);
        visitor.reals("trial squares whole", &mut self.whole);
        let mut counts = [self.seen];
        visitor.counts("trial seen", &mut counts);
        [self.seen] = counts;
    }
}
