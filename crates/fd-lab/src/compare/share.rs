//! Shares of runs with exact intervals.

use serde::{Deserialize, Serialize};
use statrs::distribution::{Beta, ContinuousCDF, StudentsT};

use super::rounded::rounded;

/// Probability that an interval misses the truth, both sides together.
const MISS: f64 = 0.05;

/// A share of runs with its 95 % interval.
///
/// The interval is exact (Clopper & Pearson 1934) for runs that are independent. Runs of one engine are
/// not: an engine whose bias was learned badly alarms in many of them. [`Share::clustered`] then counts
/// the runs for as many as they are worth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Share {
    /// Runs that count.
    pub hits: u64,
    /// All runs.
    pub of: u64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

impl Share {
    /// The share of hits among independent runs.
    ///
    /// ```
    /// use fd_lab::compare::Share;
    ///
    /// // None of 10: the upper end is 1 − 0.025^(1/10).
    /// let none = Share::new(0, 10);
    /// assert_eq!(none.low, 0.0);
    /// assert!((none.high - (1.0 - 0.025_f64.powf(0.1))).abs() < 1e-5);
    /// ```
    #[must_use]
    pub fn new(hits: u64, of: u64) -> Self {
        Self::worth(hits, of, of as f64)
    }

    /// The share of hits among the runs of several engines, `(hits, runs)` of each: the exact interval
    /// for as many independent runs as these are worth (Korn & Graubard 1998).
    ///
    /// That number is the number of runs over the design effect, the variance of the share as the
    /// engines scatter over that of independent runs, with a correction for the few engines that it is
    /// taken from. It is at most the number of runs, and all of them where there are none or only hits,
    /// as nothing scatters then.
    ///
    /// ```
    /// use fd_lab::compare::Share;
    ///
    /// // Half of the engines alarm always: 40 runs are worth little more than 4.
    /// let split = Share::clustered(&[(10, 10), (0, 10), (10, 10), (0, 10)]);
    /// let alike = Share::clustered(&[(5, 10), (5, 10), (5, 10), (5, 10)]);
    /// assert!(split.high - split.low > 2.0 * (alike.high - alike.low));
    /// assert_eq!(alike, Share::new(20, 40));
    /// ```
    #[must_use]
    pub fn clustered(engines: &[(u64, u64)]) -> Self {
        let sum = |part: fn(&(u64, u64)) -> u64| engines.iter().map(part).sum::<u64>();
        let (hits, of) = (sum(|e| e.0), sum(|e| e.1));
        let count = engines.iter().filter(|e| e.1 > 0).count() as f64;
        let (n, share) = (of as f64, hits as f64 / of as f64);
        if hits == 0 || hits >= of || count < 2.0 {
            return Self::new(hits, of);
        }
        let deviation = |e: &(u64, u64)| (e.0 as f64 - share * e.1 as f64).powi(2);
        let variance = count / (count - 1.0) * engines.iter().map(deviation).sum::<f64>() / (n * n);
        let independent = share * (1.0 - share) / n;
        let quantile = |freedom: f64| {
            StudentsT::new(0.0, 1.0, freedom).map_or(1.0, |t| t.inverse_cdf(1.0 - 0.5 * MISS))
        };
        let few = (quantile(n - 1.0) / quantile(count - 1.0)).powi(2);
        let worth = few * n * independent / variance.max(f64::MIN_POSITIVE);
        Self::worth(hits, of, worth.clamp(1.0, n))
    }

    /// The interval of `hits` in `of` runs that are worth the given number of independent ones.
    fn worth(hits: u64, of: u64, worth: f64) -> Self {
        let hits = hits.min(of);
        let k = hits as f64 * worth / of as f64;
        let end =
            |a: f64, b: f64, p: f64| Beta::new(a, b).map_or(f64::NAN, |beta| beta.inverse_cdf(p));
        let low = if hits == 0 { 0.0 } else { end(k, worth - k + 1.0, 0.5 * MISS) };
        let high = if hits == of { 1.0 } else { end(k + 1.0, worth - k, 1.0 - 0.5 * MISS) };
        Self { hits, of, low: rounded(low), high: rounded(high) }
    }

    /// The share; NaN of no runs.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.hits as f64 / self.of as f64
    }

    /// In per cent with its interval.
    #[must_use]
    pub fn text(&self) -> String {
        if self.of == 0 {
            return "-".to_owned();
        }
        let [share, low, high] = [self.share(), self.low, self.high].map(|v| 100.0 * v);
        format!("{share:.1} [{low:.1} .. {high:.1}]")
    }
}
