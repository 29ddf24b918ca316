//! Which parts of a long log tell most.
//!
//! A fit to a million samples says hardly more than one to the few thousand in which everything happens once.
//! Stretches are chosen one by one, each the one that adds most to what a linear regression on the channels, their
//! sizes and their steps would know: the largest gain of `ln det Σ φ φᵀ` (D-optimality; V. V. Fedorov, *Theory of
//! Optimal Experiments*, 1972). Such stretches hold the extremes, where limits and stops are, as well as rest.
//!
//! *When not to use:* where a whole log can be fitted. A rare event that shows in no channel's size or step, but in
//! an error of the simulator alone, is not sought here; judge all rows afterwards.

use fd_model::Record;

use crate::fit::Cholesky;

/// What is known before, per sample of a stretch, so that the first determinants are none of noise.
const BEFORE: f64 = 1e-3;

/// The stretches of a record that tell most: at most `count` ranges of `length` samples each, in order, the
/// beginning always among them, because that is where a run starts as the model says. The whole record if
/// that is not longer.
///
/// ```
/// use fd_gap::stretches::stretches;
/// use fd_model::{Channel, Record, SampleTime};
///
/// // Something happens between samples 600 and 700 only.
/// let u = |k: usize| if (600..700).contains(&k) { (0.3 * k as f64).sin() } else { 0.0 };
/// let rows = (0..1000).map(|k| ([u(k)], [2.0 * u(k)]));
/// let (inputs, outputs) = (Channel::numbered("u", 1), Channel::numbered("y", 1));
/// let record = Record::from_rows(inputs, outputs, rows, SampleTime::new(0.1)?)?;
/// assert_eq!(stretches(&record, 100, 2), [0..100, 600..700]);
/// # Ok::<(), fd_model::ModelError>(())
/// ```
#[must_use]
pub fn stretches(record: &Record, length: usize, count: usize) -> Vec<std::ops::Range<usize>> {
    let (n, length, count) = (record.len(), length.max(1), count.max(1));
    if n <= length * count {
        return std::iter::once(0..n).collect();
    }
    let features = Features::of(record);
    let blocks: Vec<Vec<f64>> =
        (0..n / length).map(|b| features.moments(record, b * length..(b + 1) * length)).collect();
    let p = features.count();
    let mut known = vec![0.0; p * p];
    (0..p).for_each(|i| known[i * p + i] = BEFORE);
    // Where a run starts is chosen already.
    let mut next = Some(0);
    let mut chosen: Vec<usize> = Vec::with_capacity(count);
    while let Some(block) = next.take() {
        known.iter_mut().zip(&blocks[block]).for_each(|(known, own)| *known += own);
        chosen.push(block);
        if chosen.len() == count {
            break;
        }
        let known_with = |block: &[f64]| {
            let sum: Vec<f64> = known.iter().zip(block).map(|(a, b)| a + b).collect();
            Cholesky::new(&sum, p).map_or(f64::NEG_INFINITY, |factor| factor.log_determinant())
        };
        let left = (0..blocks.len()).filter(|block| !chosen.contains(block));
        let gains = left.map(|block| (block, known_with(&blocks[block])));
        // The first of equals, so that the choice is the same every time.
        let best = gains.reduce(|best, new| if best.1 < new.1 { new } else { best });
        next = best.map(|(block, _)| block);
    }
    chosen.sort_unstable();
    chosen.into_iter().map(|b| b * length..(b + 1) * length).collect()
}

/// Regressors of a sample: 1; and of each channel its value, size, step, and size of the step.
struct Features {
    /// Mean, standard deviation and size of a step of each channel, inputs first.
    scales: Vec<[f64; 3]>,
}

/// Regressors of a channel.
const PER_CHANNEL: usize = 4;

impl Features {
    fn of(record: &Record) -> Self {
        let scales = (0..record.inputs().len() + record.outputs().len()).map(|c| {
            let (mut n, mut sum, mut squares, mut steps) = (0.0_f64, 0.0, 0.0, 0.0);
            let mut last = f64::NAN;
            for k in 0..record.len() {
                let v = value(record, k, c);
                if v.is_finite() {
                    (n, sum, squares) = (n + 1.0, sum + v, squares + v * v);
                    steps += if last.is_finite() { (v - last) * (v - last) } else { 0.0 };
                }
                last = v;
            }
            let mean = sum / n.max(1.0);
            let spread = (squares / n.max(1.0) - mean * mean).max(0.0).sqrt();
            let step = (steps / n.max(1.0)).sqrt();
            let positive = |v: f64| if 0.0 < v { v } else { 1.0 };
            [mean, positive(spread), positive(step)]
        });
        Self { scales: scales.collect() }
    }

    fn count(&self) -> usize {
        1 + PER_CHANNEL * self.scales.len()
    }

    /// `Σ φ φᵀ` of a stretch, over its length; samples with holes are left out.
    fn moments(&self, record: &Record, rows: std::ops::Range<usize>) -> Vec<f64> {
        let p = self.count();
        let (mut sums, mut row) = (vec![0.0; p * p], vec![1.0; p]);
        let length = rows.len() as f64;
        for k in rows.skip(1) {
            for (c, [mean, spread, size]) in self.scales.iter().enumerate() {
                let (v, last) = (value(record, k, c), value(record, k - 1, c));
                let (v, step) = ((v - mean) / spread, (v - last) / size);
                let own = [v, v.abs(), step, step.abs()];
                row[1 + PER_CHANNEL * c..][..PER_CHANNEL].copy_from_slice(&own);
            }
            if row.iter().all(|v| v.is_finite()) {
                for (i, a) in row.iter().enumerate() {
                    for (sum, b) in sums[i * p..=i * p + i].iter_mut().zip(&row) {
                        *sum += a * b / length;
                    }
                }
            }
        }
        sums
    }
}

fn value(record: &Record, k: usize, channel: usize) -> f64 {
    let nu = record.inputs().len();
    if channel < nu { record.u(k)[channel] } else { record.y(k)[channel - nu] }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a failure here is a failed test")]
mod tests {
    use fd_model::{Channel, SampleTime};
    use proptest::prelude::*;

    use super::*;

    fn record(y: &[f64]) -> Record {
        let (inputs, outputs) = (Channel::numbered("u", 0), Channel::numbered("y", 1));
        Record::new(inputs, outputs, vec![], y.to_vec(), SampleTime::new(1.0).unwrap()).unwrap()
    }

    proptest! {
        #[test]
        fn stretches_are_parts_in_order_with_the_beginning(
            y in prop::collection::vec(prop_oneof![-1e3..1e3, Just(f64::NAN)], 1..300),
            length in 0_usize..60,
            count in 0_usize..6,
        ) {
            let chosen = stretches(&record(&y), length, count);
            prop_assert_eq!(chosen[0].start, 0);
            prop_assert!(chosen.windows(2).all(|pair| pair[0].end <= pair[1].start));
            prop_assert!(chosen.last().unwrap().end <= y.len());
            let rows: usize = chosen.iter().map(ExactSizeIterator::len).sum();
            prop_assert!(rows == y.len() || rows <= length.max(1) * count.max(1));
        }

        /// Units and zeros of channels change nothing.
        #[test]
        fn units_change_nothing(
            y in prop::collection::vec(-1.0..1.0_f64, 100..200),
            power in -20..20_i32,
        ) {
            // Powers of two, so that rounding is the same.
            let scaled: Vec<f64> = y.iter().map(|v| v * f64::from(power).exp2()).collect();
            prop_assert_eq!(stretches(&record(&y), 10, 3), stretches(&record(&scaled), 10, 3));
        }
    }
}
