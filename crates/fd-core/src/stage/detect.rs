//! From residuals to test statistics.

use crate::{scalar::Scalar, stage::Stage};

/// A change detector on a compensated residual.
///
/// Most detectors look at the residual alone. Those that follow the paper's adaptive threshold
/// `J_th(t)` need the input as well, because what a wrong model leaves in the residual grows with it.
pub trait Detector<T: Scalar = f64>: Stage<T> {
    /// Number of inputs `u`, or `None` if any number will do, also none.
    fn nu(&self) -> Option<usize> {
        None
    }

    /// Residual channels this detector was built for.
    fn residual_len(&self) -> usize;

    /// Consumes the residual of one sample, next to the input of the same sample.
    fn update(&mut self, u: &[T], r: &[T]) -> Verdict<T>;
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
