//! A sample of a filter that carries a mean and a covariance.

use fd_core::Frame;

use super::{Deviations, Estimate};

/// What is a filter's own: how it finds the deviations of states and outputs.
pub(crate) trait GaussianFilter {
    /// Time update; `false` when the model has no finite answer.
    fn predict(&mut self, u: &[f64]) -> bool;

    /// The innovation, with the deviations of states and outputs; `false` when the model has no finite answer.
    fn innovate(&mut self, frame: Frame<'_, f64>, r: &mut [f64]) -> bool;

    /// The estimate, and the deviations that the last innovation left.
    fn carried(&mut self) -> (&mut Estimate, &Deviations);

    /// Both updates; the residual is the innovation, or NaN where the estimate had to begin anew.
    fn filter(&mut self, frame: Frame<'_, f64>, r: &mut [f64]) {
        if self.predict(frame.u()) && self.innovate(frame, r) {
            let (estimate, deviations) = self.carried();
            estimate.update(deviations, r, frame.u());
        } else {
            r.fill(f64::NAN);
            self.carried().0.lose();
        }
    }
}
