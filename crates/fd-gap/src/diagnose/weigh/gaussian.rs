//! The likelihood of the errors of one output as Gaussian noise.

use std::f64::consts::PI;

use crate::evidence::{Likelihood, NoisePrior, likelihood};

/// How many errors there are, at least one.
pub(super) fn count(signals: &[Vec<f64>]) -> f64 {
    signals.iter().flatten().filter(|e| e.is_finite()).count().max(1) as f64
}

/// Log-likelihood of one output, its constant included.
pub(super) fn gaussian(signals: &[Vec<f64>], prior: NoisePrior) -> Likelihood {
    let mut found = likelihood(&[signals.to_vec()], &[prior]);
    found.log -= 0.5 * count(signals) * (2.0 * PI).ln();
    found
}
