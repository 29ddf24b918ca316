//! From inputs and bias samples to parameters.

use std::iter::Sum;

use crate::{scalar::Scalar, stage::Stage};

/// A recursive estimator of the parameters of a bias model, as seen from `u` to each residual
/// channel.
pub trait Identifier<T: Scalar = f64>: Stage<T> {
    /// Number of inputs `u`.
    fn nu(&self) -> usize;

    /// Number of residual channels.
    fn residual_len(&self) -> usize;

    /// Learns from one sample of the bias `mu`, which equals the residual while the plant is
    /// healthy.
    fn update(&mut self, u: &[T], mu: &[T]);

    /// The current parameters, those of residual channel 0 first.
    fn theta(&self) -> &[T];

    /// Writes the variances of the parameters, in their order, relative to a noise of variance 1.
    fn variance_into(&self, variance: &mut [T]);

    /// What the safeguards against wind-up have done since the last reset.
    fn guard(&self) -> GuardReport;

    /// Learns anew under another operating condition, where `theta` was in use so far. Returns
    /// whether what was learned under other conditions is kept; by default everything is
    /// forgotten, as by a reset.
    fn retrain(&mut self, theta: &[T]) -> bool {
        let _ = theta;
        self.reset();
        false
    }
}

/// What the safeguards of an [`Identifier`] have done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GuardReport {
    /// Samples not learned from, for want of excitation.
    pub skipped: u64,
    /// Times the covariance was bounded or reset.
    pub bounded: u64,
}

impl GuardReport {
    /// Whether any safeguard acted.
    #[must_use]
    pub fn acted(self) -> bool {
        self.skipped + self.bounded > 0
    }
}

/// The safeguards of several estimators together.
impl Sum for GuardReport {
    fn sum<I: Iterator<Item = Self>>(reports: I) -> Self {
        reports.fold(Self::default(), |sum, report| Self {
            skipped: sum.skipped + report.skipped,
            bounded: sum.bounded + report.bounded,
        })
    }
}
