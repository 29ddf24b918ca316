//! Medians over the seeds, with what most of them lie between.

use fd_numeric::quantile;
use serde::{Deserialize, Serialize};

/// Median with the 5 % and 95 % quantiles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Range {
    /// 5 % quantile.
    pub low: f64,
    /// Median.
    pub median: f64,
    /// 95 % quantile.
    pub high: f64,
}

impl Range {
    pub(super) fn of(values: impl Iterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.collect();
        let low = quantile(&mut values, 0.05);
        let median = quantile(&mut values, 0.5);
        Self { low, median, high: quantile(&mut values, 0.95) }
    }
}
