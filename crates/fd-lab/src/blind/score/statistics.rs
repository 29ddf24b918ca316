//! Shares with intervals, medians, calibration.

use serde::{Deserialize, Serialize};

/// Normal quantile of a two-sided 95 % interval.
const Z: f64 = 1.959_963_984_540_054;

/// A share of cases with its 95 % interval (Wilson 1927).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Rate {
    /// Cases that count.
    pub hits: usize,
    /// All cases.
    pub of: usize,
    /// The share.
    pub share: f64,
    /// Its interval.
    pub interval: [f64; 2],
}

impl Rate {
    /// The share of hits.
    ///
    /// ```
    /// use fd_lab::blind::Rate;
    ///
    /// let rate = Rate::new(9, 10);
    /// // Brown, Cai & DasGupta (2001) give 0.596 and 0.982 for 9 of 10.
    /// assert!((rate.interval[0] - 0.596).abs() < 5e-4 && (rate.interval[1] - 0.982).abs() < 5e-4);
    /// ```
    #[must_use]
    pub fn new(hits: usize, of: usize) -> Self {
        if of == 0 {
            return Self { hits, of, share: f64::NAN, interval: [0.0, 1.0] };
        }
        let (n, p) = (of as f64, hits as f64 / of as f64);
        let z = Z * Z / n;
        let middle = p + 0.5 * z;
        let half = (z * (p * (1.0 - p) + 0.25 * z)).sqrt();
        let end = |value: f64| (value / (1.0 + z)).clamp(0.0, 1.0);
        Self { hits, of, share: p, interval: [end(middle - half), end(middle + half)] }
    }

    /// The share of those for which something holds.
    pub(super) fn of<T>(all: &[T], holds: impl Fn(&T) -> bool) -> Self {
        Self::new(all.iter().filter(|one| holds(one)).count(), all.len())
    }

    /// In words.
    pub(super) fn text(&self) -> String {
        if self.of == 0 {
            return "-".to_owned();
        }
        let [low, high] = self.interval;
        format!("{:.3} ({low:.3}..{high:.3}; {} of {})", self.share, self.hits, self.of)
    }
}

/// Cases of about the same stated probability.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Bin {
    /// Mean stated probability.
    pub stated: f64,
    /// How often it was right.
    pub right: Rate,
}

/// How well probabilities say how often an answer is right.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// Mean difference of stated and real share, weighted by cases, in ten bins of equal width
    /// (Naeini, Cooper & Hauskrecht 2015).
    pub error: f64,
    /// Bins that are not empty.
    pub bins: Vec<Bin>,
}

impl Calibration {
    /// From stated probabilities and whether the answer was right.
    ///
    /// ```
    /// use fd_lab::blind::Calibration;
    ///
    /// let sure = Calibration::of(&[(0.95, true), (0.95, true), (0.95, false), (0.95, true)]);
    /// assert!((sure.error - 0.2).abs() < 1e-12);
    /// ```
    #[must_use]
    pub fn of(answers: &[(f64, bool)]) -> Self {
        let mut bins = Vec::new();
        let mut error = 0.0;
        for i in 0..10 {
            let (low, high) = (f64::from(i) / 10.0, f64::from(i + 1) / 10.0);
            let inside: Vec<&(f64, bool)> = answers
                .iter()
                .filter(|(p, _)| low <= *p && (*p < high || (i == 9 && *p <= 1.0 + 1e-9)))
                .collect();
            if inside.is_empty() {
                continue;
            }
            let n = inside.len() as f64;
            let stated = inside.iter().map(|(p, _)| p).sum::<f64>() / n;
            let right = Rate::of(&inside, |(_, right)| *right);
            error += n / answers.len() as f64 * (stated - right.share).abs();
            bins.push(Bin { stated, right });
        }
        Self { error, bins }
    }
}
