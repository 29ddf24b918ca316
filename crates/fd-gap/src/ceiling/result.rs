//! The result: how much a black box could remove.

use schemars::JsonSchema;
use serde::Serialize;

use crate::shrink::Closed;

/// How much of the held-out gap a flexible black-box compensation removes.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Ceiling {
    /// The bias model of Patton & Chen (1992), a linear difference equation in free run.
    pub linear: Option<Compensation>,
    /// A small nonlinear one.
    pub nonlinear: Option<Compensation>,
    /// In words.
    pub statement: String,
}

impl Ceiling {
    /// The larger of the shares.
    #[must_use]
    pub fn share(&self) -> Option<Closed> {
        let both = [&self.linear, &self.nonlinear];
        let shares = both.into_iter().flatten().filter_map(|c| c.closed);
        shares.max_by(|a, b| a.fraction.total_cmp(&b.fraction))
    }
}

/// A compensation of the residual of the refitted model, learned from the training logs.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Compensation {
    /// Past values of the bias that it feeds back, and of each input that it looks at.
    pub orders: [usize; 2],
    /// Held-out gap of each output with it, in its unit.
    pub after: Vec<f64>,
    /// Share of the reducible gap of the refitted model that it closes.
    pub closed: Option<Closed>,
}
