//! Shares of runs with exact intervals.

use serde::{Deserialize, Serialize};
use statrs::distribution::{Beta, ContinuousCDF};

/// Probability that an interval misses the truth, both sides together.
const MISS: f64 = 0.05;

/// A share of runs with its exact 95 % interval (Clopper & Pearson 1934).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Share {
    /// Runs that count.
    pub hits: u64,
    /// All runs.
    pub of: u64,
    /// The share; NaN of no runs.
    pub share: f64,
    /// Lower end of its interval.
    pub low: f64,
    /// Upper end of its interval.
    pub high: f64,
}

impl Share {
    /// The share of hits among runs.
    ///
    /// ```
    /// use fdiag::compare::Share;
    ///
    /// // None of 10: the upper end is 1 − 0.025^(1/10).
    /// let none = Share::new(0, 10);
    /// assert_eq!(none.low, 0.0);
    /// assert!((none.high - (1.0 - 0.025_f64.powf(0.1))).abs() < 1e-9);
    /// ```
    #[must_use]
    pub fn new(hits: u64, of: u64) -> Self {
        let hits = hits.min(of);
        let (k, n) = (hits as f64, of as f64);
        let end =
            |a: f64, b: f64, p: f64| Beta::new(a, b).map_or(f64::NAN, |beta| beta.inverse_cdf(p));
        let low = if hits == 0 { 0.0 } else { end(k, n - k + 1.0, 0.5 * MISS) };
        let high = if hits == of { 1.0 } else { end(k + 1.0, n - k, 1.0 - 0.5 * MISS) };
        Self { hits, of, share: k / n, low, high }
    }

    /// In per cent with its interval.
    #[must_use]
    pub fn text(&self) -> String {
        if self.of == 0 {
            return "-".to_owned();
        }
        let [share, low, high] = [self.share, self.low, self.high].map(|v| 100.0 * v);
        format!("{share:.1} [{low:.1} .. {high:.1}]")
    }
}
