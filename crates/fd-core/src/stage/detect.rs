//! From residuals to test statistics.

use crate::{scalar::Scalar, stage::Stage};

/// A change detector on a compensated residual.
pub trait Detector<T: Scalar = f64>: Stage<T> {
    /// Residual channels this detector was built for.
    fn residual_len(&self) -> usize;

    /// Consumes one residual.
    fn update(&mut self, r: &[T]) -> Verdict<T>;
}

/// A test statistic next to the threshold it is compared with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict<T> {
    /// Value of the test statistic.
    pub statistic: T,
    /// Largest value that counts as normal, in the unit of the statistic.
    pub threshold: T,
}

impl<T: Scalar> Verdict<T> {
    /// Whether the statistic left its normal range.
    #[must_use]
    pub fn alarm(&self) -> bool {
        self.threshold < self.statistic
    }
}
