//! Information criteria.

use std::fmt;

use serde::{Deserialize, Serialize};

/// What a choice of orders is judged by; the smaller the better.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Criterion {
    /// Akaike's information criterion.
    Aic,
    /// The same, corrected for few rows.
    Aicc,
    /// The Bayesian (Schwarz) information criterion.
    Bic,
    /// Logarithm of the final prediction error.
    Fpe,
    /// Simulation error on held-out records.
    #[default]
    HeldOut,
}

impl Criterion {
    /// All criteria, in the order in which they are listed above.
    pub const ALL: [Self; 5] = [Self::Aic, Self::Aicc, Self::Bic, Self::Fpe, Self::HeldOut];
}

impl fmt::Display for Criterion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Aic => "AIC",
            Self::Aicc => "AICc",
            Self::Bic => "BIC",
            Self::Fpe => "FPE",
            Self::HeldOut => "held-out simulation",
        })
    }
}

/// The four information criteria of one model.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Information {
    pub aic: f64,
    pub aicc: f64,
    pub bic: f64,
    pub fpe: f64,
}

impl Information {
    /// Adds a residual channel with mean squared error `v` over `rows` rows.
    pub(super) fn add_channel(&mut self, v: f64, rows: usize, parameters: usize) {
        let (n, p) = (rows as f64, parameters as f64);
        let aic = n * v.ln() + 2.0 * p;
        self.aic += aic;
        self.aicc +=
            if n > p + 1.0 { aic + 2.0 * p * (p + 1.0) / (n - p - 1.0) } else { f64::INFINITY };
        self.bic += n * v.ln() + p * n.ln();
        self.fpe += v.ln() + ((n + p) / (n - p)).ln();
    }
}
