//! Where steps go: a report, a plot, a log or a closure.

use crate::{pipeline::Step, scalar::Scalar};

/// A consumer of steps.
///
/// Whatever wants to know what a [`Pipeline`](crate::Pipeline) found is a sink: a report, a plot, a
/// file. Any closure over a step is one. A sink borrows the step and copies what it keeps; it may
/// allocate and be slow, which a stage may not.
///
/// ```
/// use fd_core::{Events, Sink, Step, stage::{Decision, Phase, Verdict}};
///
/// let mut worst = 0.0_f64;
/// let mut keep_worst = |step: Step<'_, f64>| worst = worst.max(step.verdict.statistic);
/// for (k, statistic) in [(0, 0.3), (1, 0.9), (2, 0.2)] {
///     keep_worst.record(Step {
///         k,
///         residual: &[],
///         compensated: &[],
///         phase: Phase::Compensating,
///         verdict: Verdict { statistic, threshold: 1.0 },
///         decision: Decision::Nominal,
///         events: Events::none(),
///     });
/// }
/// assert_eq!(worst, 0.9);
/// ```
pub trait Sink<T: Scalar = f64> {
    /// Takes note of one step.
    fn record(&mut self, step: Step<'_, T>);
}

impl<T: Scalar, F: FnMut(Step<'_, T>)> Sink<T> for F {
    fn record(&mut self, step: Step<'_, T>) {
        self(step);
    }
}
