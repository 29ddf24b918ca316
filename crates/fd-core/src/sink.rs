//! Where steps go: a report, a plot, a log or a closure.

use crate::{pipeline::Step, scalar::Scalar};

/// A consumer of steps.
pub trait Sink<T: Scalar = f64> {
    /// Takes note of one step.
    fn record(&mut self, step: Step<'_, T>);
}

impl<T: Scalar, F: FnMut(Step<'_, T>)> Sink<T> for F {
    fn record(&mut self, step: Step<'_, T>) {
        self(step);
    }
}
