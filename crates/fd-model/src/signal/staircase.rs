//! Random levels held for random times.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};

use crate::{
    domain::SampleTime,
    signal::{
        check::{finite, in_range, positive_seconds},
        error::SignalError,
    },
};

/// Levels uniform in `low` to `high`, each held for a time uniform in `hold_min_s` to
/// `hold_max_s`, rounded to whole samples and at least one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Staircase {
    /// Lowest level, in the unit of the channel.
    pub low: f64,
    /// Highest level, in the unit of the channel.
    pub high: f64,
    /// Shortest hold, in seconds.
    pub hold_min_s: f64,
    /// Longest hold, in seconds.
    pub hold_max_s: f64,
    /// Seed of levels and holds.
    pub seed: u64,
}

impl Staircase {
    /// Levels between two values, each held between two times in seconds.
    ///
    /// ```
    /// # use fd_model::{SampleTime, signal::Staircase};
    /// let u = Staircase::new([3.0, 10.0], [60.0, 300.0], 7).values(900, SampleTime::new(1.0)?)?;
    /// assert!(u.iter().all(|&u| 3.0 <= u && u < 10.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn new([low, high]: [f64; 2], [hold_min_s, hold_max_s]: [f64; 2], seed: u64) -> Self {
        Self { low, high, hold_min_s, hold_max_s, seed }
    }

    /// The first `n` samples.
    ///
    /// # Errors
    ///
    /// Returns the first parameter outside its range.
    pub fn values(&self, n: usize, ts: SampleTime) -> Result<Vec<f64>, SignalError> {
        finite("staircase", "low", self.low)?;
        in_range("staircase", "high", "at least `low`", self.high, self.low <= self.high)?;
        positive_seconds("staircase", "hold_min_s", self.hold_min_s)?;
        let ordered = self.hold_min_s <= self.hold_max_s;
        in_range("staircase", "hold_max_s", "at least `hold_min_s`", self.hold_max_s, ordered)?;

        let mut rng = Xoshiro256PlusPlus::seed_from_u64(self.seed);
        let mut between = |low: f64, high: f64| low + (high - low) * rng.random::<f64>();
        let mut values = Vec::with_capacity(n);
        while values.len() < n {
            let level = between(self.low, self.high);
            let hold = (between(self.hold_min_s, self.hold_max_s) / ts.seconds()).round().max(1.0);
            // Saturates for holds beyond any memory.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let hold = (hold as usize).min(n - values.len());
            values.extend(std::iter::repeat_n(level, hold));
        }
        Ok(values)
    }
}
