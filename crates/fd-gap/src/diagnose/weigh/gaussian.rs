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

#[cfg(test)]
mod tests {
    use super::*;

    /// The density of a normal distribution at three values, of its own size and of another.
    #[test]
    fn the_constant_is_in_it() {
        let signals = vec![vec![1.0, f64::NAN, -1.0], vec![1.0]];
        assert!((count(&signals) - 3.0).abs() < 1e-12 && (count(&[]) - 1.0).abs() < 1e-12);
        for size in [1.0, 2.0_f64] {
            let known = NoisePrior { centre: size.ln(), ..NoisePrior::white(1e-6) };
            let expected = -3.0 * (size.ln() + 0.5 * (2.0 * PI).ln() + 0.5 / (size * size));
            let found = gaussian(&signals, known).log;
            assert!((found - expected).abs() < 1e-6, "{size}: {found} {expected}");
        }
    }
}
