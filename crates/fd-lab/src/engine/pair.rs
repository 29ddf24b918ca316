//! A figure without and with compensation.

use serde::{Deserialize, Serialize};

/// A figure without and with compensation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pair {
    /// Of the primary residual.
    pub primary: f64,
    /// Of the compensated residual.
    pub compensated: f64,
}

impl Pair {
    /// How many times smaller it is with compensation.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.primary / self.compensated
    }
}
