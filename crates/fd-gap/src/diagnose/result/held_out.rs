//! The gap on held-out logs.

use schemars::JsonSchema;
use serde::Serialize;

use super::Diagnosis;
use crate::{fit::Horizon, shrink::Closed};

/// The gap on held-out data at one horizon.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct HeldOut {
    /// Horizon.
    pub horizon: Horizon,
    /// Length of the horizon, in seconds; the longest log for a free run.
    pub seconds: f64,
    /// Root mean square error of each output with nominal parameters, in its unit.
    pub nominal: Vec<f64>,
    /// The same with refitted parameters.
    pub refit: Vec<f64>,
    /// The same with the best explanation.
    pub after: Vec<f64>,
    /// The same with no model at all, by the mean of the fitted logs.
    pub constant: Vec<f64>,
    /// The same by the last value before each forecast.
    pub last_value: Vec<f64>,
    /// Noise floor of each output, in its unit.
    pub floor: Vec<f64>,
    /// Share of the reducible gap of the nominal model that is closed.
    pub closed_of_nominal: Option<Closed>,
    /// Share of the reducible gap of the refitted model that is closed.
    pub closed_of_refit: Option<Closed>,
    /// Whether a path over time, which is the best explanation, was drawn anew in these logs: `after` is no
    /// forecast of that then.
    pub is_redrawn: bool,
    /// Errors (simulated less measured) over the first held-out log, as it was taken to begin, with the model as it came and
    /// with the best explanation: per output, in its unit, NaN where nothing was measured or forecast; not serialised.
    #[serde(skip)]
    pub errors: [Vec<Vec<f64>>; 2],
}

impl HeldOut {
    /// The share that counts: of what refitted parameters leave, or of the nominal gap when they leave
    /// none; `None` when there is no gap at all.
    #[must_use]
    pub fn closed(&self) -> Option<Closed> {
        self.closed_of_refit.or(self.closed_of_nominal)
    }

    /// Sizes of all outputs together, root mean square, in `sigma`.
    pub(crate) fn total(&self, of: fn(&Self) -> &Vec<f64>, sigma: &[f64]) -> f64 {
        let each = of(self).iter().zip(sigma);
        let squares: f64 = each.map(|(size, sigma)| (size / sigma).powi(2)).sum();
        (squares / sigma.len().max(1) as f64).sqrt()
    }
}

impl Diagnosis {
    /// The held-out forecasts that say most: at the longest horizon at which the best explanation is nearer than the mean of
    /// the fitted logs, or at the shortest where it never is. `None` without held-out logs.
    #[must_use]
    pub fn forecast(&self) -> Option<&HeldOut> {
        let foretells = |held_out: &&HeldOut| {
            held_out.total(|h| &h.after, &self.sigma) < held_out.total(|h| &h.constant, &self.sigma)
        };
        let by_length = |a: &&HeldOut, b: &&HeldOut| a.seconds.total_cmp(&b.seconds);
        let longest = self.held_out.iter().filter(foretells).max_by(by_length);
        longest.or_else(|| self.held_out.iter().min_by(by_length))
    }
}
