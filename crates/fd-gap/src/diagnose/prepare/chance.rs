//! What chance does to the evidence of a simulator that does not repeat itself.
//!
//! Two causes are compared by runs of their own, and each run has noise of its own. Let a part `a` of the variance of
//! an error be the simulator's. Of `n` samples, half the sum of squares then varies by `√(n a (1 − a/2))` between runs:
//! `Σ(e + v)²` has the variance `4nσ²s² + 2ns⁴` for given `e`, with `s² = a` and `σ² = 1 − a`. Evidence differs by `√2`
//! times that between two causes of which neither is better, and it is divided by a temperature of that size. What
//! speaks clearly for a cause grows with `n`, and chance with its root, so that it is still found.

use super::Prepared;
use crate::diagnose::settings::Settings;

impl Prepared {
    /// The settings for evidence that is partly chance; as they are where the simulator repeats itself. A linear model
    /// of it has the same noise in all its runs, which is no chance.
    pub(in crate::diagnose) fn with_chance(&self, settings: &Settings) -> Settings {
        if self.null.problem.simulator().repeats() {
            return settings.clone();
        }
        let logs = &self.null.problem.plan().logs;
        let parts = self.noise.spread.iter().zip(&self.noise.sigma);
        let variances = parts.enumerate().map(|(c, (spread, sigma))| {
            let column = logs.iter().flat_map(|log| log.y.iter().skip(c).step_by(log.ny));
            let n = column.filter(|y| y.is_finite()).count() as f64;
            let a = (spread / sigma).powi(2).min(1.0);
            n * a * (1.0 - 0.5 * a)
        });
        let chance = (2.0 * variances.sum::<f64>()).sqrt();
        let temperature = settings.temperature.hypot(chance);
        let bayes_factor = settings.bayes_factor.powf(temperature / settings.temperature);
        Settings { temperature, bayes_factor, ..settings.clone() }
    }
}
