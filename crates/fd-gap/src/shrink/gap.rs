//! The size of a gap, and how much of it an effect closes.

use fd_compensate::calibrate::{CircularBlocks, autocorrelation_time};
use fd_numeric::rms;
use schemars::JsonSchema;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, Normal};

/// Errors per output, segment and sample, in units of the noise; NaN where there is none.
pub type Errors = [Vec<Vec<f64>>];

/// Length of a bootstrap block, in autocorrelation times.
pub(super) const BLOCK: f64 = 5.0;
/// Relative standard deviation of a noise floor, which comes from about a thousand samples:
/// `1/√(2n)` of the noise itself, and as much again of the method.
const FLOOR_SPREAD: f64 = 0.03;
/// A gap before that is less than this above its floor cannot be shared out.
const REDUCIBLE: f64 = 0.01;

/// Root of the mean square of errors per output, in units of the noise.
#[must_use]
pub fn gap_per_output(errors: &Errors) -> Vec<f64> {
    errors.iter().map(|signals| rms(finite(signals.iter().flatten()))).collect()
}

/// Root of the mean square of all errors, in units of the noise.
///
/// ```
/// use fd_gap::shrink::gap;
///
/// assert_eq!(gap(&[vec![vec![3.0, f64::NAN]], vec![vec![-3.0, 3.0]]]), 3.0);
/// ```
#[must_use]
pub fn gap(errors: &Errors) -> f64 {
    rms(finite(errors.iter().flatten().flatten()))
}

fn finite<'a>(values: impl Iterator<Item = &'a f64>) -> impl Iterator<Item = f64> {
    values.copied().filter(|value| value.is_finite())
}

/// A share of the reducible gap, with a 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Closed {
    /// `1 − (after − floor)/(before − floor)`; 1 is all of it, negative is harm.
    pub fraction: f64,
    /// Bounds of the 95 % interval of that share.
    pub interval: [f64; 2],
    /// Length of a block of the bootstrap, in samples.
    pub block: usize,
}

/// How much wider than a bootstrap within one run the interval of another run is: twice covered
/// nine of ten unseen runs on development cases of the blind test, once three of four.
const BETWEEN_RUNS: f64 = 2.0;

impl Closed {
    /// The same share with an interval for other runs of the kind: a bootstrap within one run does
    /// not see how runs differ. No cause closes more than all of a gap: a share above 1 shows that the floor is too high by
    /// about so much, which the interval then reaches to on the other side of 1.
    ///
    /// ```
    /// use fd_gap::shrink::Closed;
    ///
    /// let closed = Closed { fraction: 0.75, interval: [0.5, 1.0], block: 5 };
    /// assert_eq!(closed.between_runs().interval, [0.25, 1.25]);
    /// let more_than_all = Closed { fraction: 1.125, interval: [1.0625, 1.1875], block: 5 };
    /// assert_eq!(more_than_all.between_runs().interval, [0.875, 1.25]);
    /// ```
    #[must_use]
    pub fn between_runs(self) -> Self {
        let widened = |end: f64| self.fraction + BETWEEN_RUNS * (end - self.fraction);
        let [low, high] = self.interval.map(widened);
        let beyond = self.fraction - 1.0;
        let low = if 0.0 < beyond { low.min(1.0 - beyond) } else { low };
        Self { interval: [low, high], ..self }
    }
}

/// The share of the gap above `floor` that is closed from `before` to `after`, with a
/// moving-block bootstrap interval (Künsch 1989; here on the data closed to a circle) of
/// `replicas` replicas; `seed` settles the answer. Blocks are 5 autocorrelation times long, or a
/// tenth of the data when their memory is longer than can be told.
///
/// `None` when there is no gap above the floor to begin with.
#[must_use]
pub fn closed(
    before: &Errors,
    after: &Errors,
    floor: f64,
    replicas: usize,
    seed: u64,
) -> Option<Closed> {
    let squares = pairs(before, after);
    let total = |indices: &mut dyn Iterator<Item = usize>, floor: f64| -> Option<f64> {
        let mut sums = [0.0; 3];
        for [before, after, count] in indices.map(|i| squares[i]) {
            sums[0] += before;
            sums[1] += after;
            sums[2] += count;
        }
        let [before, after] = [0, 1].map(|i| f64::sqrt(sums[i] / sums[2]) - floor);
        (REDUCIBLE * floor < before).then(|| 1.0 - after / before)
    };
    let n = squares.len();
    let fraction = total(&mut (0..n), floor)?;
    let memory = |errors: &Errors| {
        let times = errors.iter().map(|signals| {
            let signal: Vec<f64> =
                signals.iter().flatten().copied().filter(|v| v.is_finite()).collect();
            autocorrelation_time(&signal).map_or(n as f64 / 10.0 / BLOCK, f64::ceil)
        });
        times.fold(1.0, f64::max)
    };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at least 5")]
    let block = ((BLOCK * memory(before).max(memory(after))) as usize).min(n.div_ceil(3));
    let mut indices = CircularBlocks::new(n, block, seed);
    let mut shares: Vec<f64> = Vec::with_capacity(replicas);
    let normal = Normal::standard();
    for i in 0..replicas {
        // The noise floor is an estimate as well: its quantiles, one per replica.
        let z = normal.inverse_cdf((i as f64 + 0.5) / replicas as f64);
        let floor = floor * (1.0 + FLOOR_SPREAD * z);
        shares.extend(total(&mut indices.by_ref().take(n), floor));
    }
    shares.sort_by(f64::total_cmp);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within 0..=1")]
    let quantile = |p: f64| {
        let place = (p * shares.len().saturating_sub(1) as f64).round() as usize;
        shares.get(place).copied().unwrap_or(fraction)
    };
    Some(Closed { fraction, interval: [quantile(0.025), quantile(0.975)], block })
}

/// Sums of squares of a sample over the outputs, before and after, and how many there are.
fn pairs(before: &Errors, after: &Errors) -> Vec<[f64; 3]> {
    let mut all = Vec::new();
    let segments = before.first().map_or(0, Vec::len);
    for s in 0..segments {
        for k in 0..before[0][s].len() {
            let mut sums = [0.0; 3];
            for (before, after) in before.iter().zip(after) {
                let (b, a) = (before[s][k], after[s][k]);
                if b.is_finite() && a.is_finite() {
                    sums[0] += b * b;
                    sums[1] += a * a;
                    sums[2] += 1.0;
                }
            }
            if 0.0 < sums[2] {
                all.push(sums);
            }
        }
    }
    all
}
