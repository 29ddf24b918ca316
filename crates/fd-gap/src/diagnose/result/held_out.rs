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
}

impl HeldOut {
    /// The share that counts: of what refitted parameters leave, or of the nominal gap when they leave
    /// none; `None` when there is no gap at all.
    #[must_use]
    pub fn closed(&self) -> Option<Closed> {
        self.closed_of_refit.or(self.closed_of_nominal)
    }
}

impl Diagnosis {
    /// The held-out forecasts that say most: at the longest horizon at which the best explanation is nearer than the mean of
    /// the fitted logs, or at the shortest where it never is. `None` without held-out logs.
    #[must_use]
    pub fn forecast(&self) -> Option<&HeldOut> {
        let squares = |sizes: &[f64]| -> f64 {
            sizes.iter().zip(&self.sigma).map(|(size, sigma)| (size / sigma).powi(2)).sum()
        };
        let mut all: Vec<&HeldOut> = self.held_out.iter().collect();
        all.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
        let foretells =
            |held_out: &&&HeldOut| squares(&held_out.after) < squares(&held_out.constant);
        all.iter().rev().find(foretells).or(all.first()).copied()
    }
}
