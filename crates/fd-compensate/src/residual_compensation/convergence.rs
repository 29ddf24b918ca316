//! The test that ends a training.

use fd_core::{Scalar, StateVisitor, stage::Identifier};

use super::design::{Convergence, ConvergenceRule};

/// Counts the samples in a row in which the parameters hardly moved.
#[derive(Clone, Debug)]
pub(super) struct ConvergenceTest<T> {
    tolerance: T,
    /// `μ` of the paper's rule, else infinite.
    bound: T,
    consecutive: u64,
    least_samples: u64,
    relative_standard_error: Option<T>,
    previous: Vec<T>,
    variance: Vec<T>,
    /// Sum of squared innovations of each channel since training started.
    squares: Vec<T>,
    streak: u64,
    learned: u64,
}

impl<T: Scalar> ConvergenceTest<T> {
    pub(super) fn new(plan: &Convergence, theta_len: usize, residual_len: usize) -> Self {
        let (tolerance, bound, consecutive) = match plan.rule {
            ConvergenceRule::InARow => (plan.tolerance, f64::INFINITY, plan.consecutive),
            ConvergenceRule::TwoConstants { epsilon, mu } => (epsilon, mu, 1),
        };
        Self {
            tolerance: T::from_design(tolerance),
            bound: T::from_design(bound),
            consecutive,
            least_samples: plan.least_samples,
            relative_standard_error: plan.relative_standard_error.map(T::from_design),
            previous: vec![T::zero(); theta_len],
            variance: vec![T::zero(); theta_len],
            squares: vec![T::zero(); residual_len],
            streak: 0,
            learned: 0,
        }
    }

    /// Samples learned from.
    pub(super) fn learned(&self) -> u64 {
        self.learned
    }

    /// Lets `identifier` learn one sample and reports whether its parameters have converged.
    pub(super) fn learn(
        &mut self,
        identifier: &mut impl Identifier<T>,
        u: &[T],
        r: &[T],
        innovation: &[T],
    ) -> bool {
        let skipped = identifier.guard().skipped;
        self.previous.copy_from_slice(identifier.theta());
        identifier.update(u, r);
        if identifier.guard().skipped != skipped {
            // A skipped sample leaves θ where it was and proves nothing.
            return false;
        }
        self.learned += 1;
        for (sum, &e) in self.squares.iter_mut().zip(innovation) {
            *sum += e * e;
        }
        let theta = identifier.theta();
        let moved = norm(theta.iter().zip(&self.previous).map(|(&new, &old)| new - old));
        let relative = self.tolerance * norm(self.previous.iter().copied());
        let still = moved <= relative.min(self.bound);
        self.streak = if still { self.streak + 1 } else { 0 };
        self.streak >= self.consecutive
            && self.learned >= self.least_samples
            && self.is_precise(identifier)
    }

    /// Whether the standard error of θ is small next to θ.
    fn is_precise(&mut self, identifier: &impl Identifier<T>) -> bool {
        let Some(bound) = self.relative_standard_error else { return true };
        identifier.variance_into(&mut self.variance);
        let variance = self.variance.iter().fold(T::zero(), |sum, &v| sum + v);
        let worst = self.squares.iter().fold(T::zero(), |worst, &v| worst.max(v));
        let noise = worst / T::from_design(self.learned.max(1) as f64);
        (variance * noise).sqrt() <= bound * norm(identifier.theta().iter().copied())
    }

    /// Demands a new streak, without forgetting what was learned.
    pub(super) fn doubt(&mut self) {
        self.streak = 0;
    }

    pub(super) fn reset(&mut self) {
        self.squares.fill(T::zero());
        self.streak = 0;
        self.learned = 0;
    }

    pub(super) fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("training squared innovations", &mut self.squares);
        let mut counts = [self.streak, self.learned];
        visitor.counts("training streak, learned", &mut counts);
        [self.streak, self.learned] = counts;
    }
}

fn norm<T: Scalar>(values: impl Iterator<Item = T>) -> T {
    values.fold(T::zero(), |sum, v| sum + v * v).sqrt()
}
