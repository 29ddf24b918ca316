//! Quantiles of a sample, inside and beyond it.

use crate::count::whole;

/// The smallest of the values that at most the share `rate` of them exceeds. `sorted` is ascending and
/// not empty.
pub(super) fn upper_quantile(sorted: &[f64], rate: f64) -> f64 {
    let n = sorted.len();
    // At most this many may exceed it; the small excess undoes the rounding of rate * n.
    let above = whole(rate * n as f64 * (1.0 + 4.0 * f64::EPSILON)).min(n - 1);
    sorted[n - 1 - above]
}

/// The quantile for a `rate` that the values cannot resolve: an exponential tail fitted to what exceeds
/// the quantile of `resolved`. Right for exponential tails, too high (safe) for Gaussian ones, too low
/// for heavier ones.
pub(super) fn exponential_tail(sorted: &[f64], resolved: f64, rate: f64) -> f64 {
    let foot = upper_quantile(sorted, resolved);
    let above = sorted.partition_point(|&v| v <= foot);
    let excess: Vec<f64> = sorted[above..].iter().map(|v| v - foot).collect();
    let mean = excess.iter().sum::<f64>() / (excess.len() as f64).max(1.0);
    foot + mean * (resolved / rate).ln()
}

/// A sample as a distribution: as it is up to the quantile of `resolved`, beyond that with an exponential tail.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tail<'a> {
    /// Ascending, not empty.
    pub sorted: &'a [f64],
    /// The share that the tail takes over from.
    pub resolved: f64,
}

impl Tail<'_> {
    /// The share of further values that exceeds `t`, the inverse of [`exponential_tail`].
    pub(super) fn exceeding(&self, t: f64) -> f64 {
        let n = self.sorted.len();
        let foot = upper_quantile(self.sorted, self.resolved);
        if t < foot {
            return (n - self.sorted.partition_point(|&v| v <= t)) as f64 / n as f64;
        }
        let above = &self.sorted[self.sorted.partition_point(|&v| v <= foot)..];
        let mean = above.iter().map(|v| v - foot).sum::<f64>() / (above.len() as f64).max(1.0);
        if mean > 0.0 { self.resolved * (-(t - foot) / mean).exp() } else { 0.0 }
    }
}

/// The value that one more sample like the `n` given ones exceeds with this probability, when what exceeds
/// their median is exponential: the ratio of a fresh excess to the mean of `m` others then has the F
/// distribution of 2 and 2m degrees of freedom, `P(x > t) = (1 + t / (m mean))^−m`. The median itself for all
/// that is likelier than to exceed it. `sorted` is ascending and has at least two values.
pub(super) fn predictive_tail(sorted: &[f64], probability: f64) -> f64 {
    let n = sorted.len();
    let above = n / 2;
    let foot = sorted[n - above - 1];
    let mean = sorted[n - above..].iter().map(|v| v - foot).sum::<f64>() / above as f64;
    let at_foot = (above + 1) as f64 / (n + 1) as f64;
    let ratio = (at_foot / probability).max(1.0);
    foot + above as f64 * mean * (ratio.powf((above as f64).recip()) - 1.0)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;

    #[test]
    fn a_fresh_value_exceeds_the_predicted_one_as_often_as_stated() {
        // Ten values of the unit exponential, then one more: the promise holds on average over both.
        let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
        let mut draw = || -(1.0 - random.random::<f64>()).ln();
        let (trials, probability) = (40_000, 0.02);
        let mut exceeded = 0.0;
        for _ in 0..trials {
            let mut sorted: Vec<f64> = (0..10).map(|_| draw()).collect();
            sorted.sort_unstable_by(f64::total_cmp);
            exceeded += f64::from(u8::from(draw() > predictive_tail(&sorted, probability)));
        }
        let rate = exceeded / f64::from(trials);
        // Standard error sqrt(0.02 · 0.98 / 40 000) = 7e-4, four of them.
        assert!((rate - probability).abs() < 2.8e-3, "{rate}");
    }

    #[test]
    fn no_more_than_the_rate_exceeds_the_quantile() {
        let sorted: Vec<f64> = (0..100).map(f64::from).collect();
        for (rate, expected) in [(0.0, 99.0), (0.01, 98.0), (0.05, 94.0), (0.055, 94.0)] {
            let quantile = upper_quantile(&sorted, rate);
            assert!((quantile - expected).abs() < f64::EPSILON, "{rate}: {quantile}");
        }
    }

    #[test]
    fn a_tail_is_the_inverse_of_its_quantile() {
        let sorted: Vec<f64> = (1..=200).map(|i| (f64::from(i) / 20.0).exp()).collect();
        let tail = Tail { sorted: &sorted, resolved: 0.1 };
        for rate in [1e-6, 1e-3, 0.05] {
            let found = tail.exceeding(exponential_tail(&sorted, 0.1, rate));
            assert!((found - rate).abs() < 1e-12 * rate.max(1e-3), "{rate}: {found}");
        }
        // Half of the values exceed their median, all of them minus infinity.
        assert!((tail.exceeding(sorted[99]) - 0.5).abs() < f64::EPSILON);
        assert!((tail.exceeding(f64::NEG_INFINITY) - 1.0).abs() < f64::EPSILON);
        let constant = Tail { sorted: &[2.0; 5], resolved: 0.5 };
        assert!(constant.exceeding(2.0) <= 0.0 && constant.exceeding(1.9) >= 1.0);
    }

    #[test]
    fn an_exponential_tail_is_continued_exactly() {
        // Quantiles of the unit exponential: its tail at rate p is -ln p.
        let n = 100_000;
        let sorted: Vec<f64> =
            (0..n).map(|i| -(1.0 - (f64::from(i) + 0.5) / f64::from(n)).ln()).collect();
        let far = exponential_tail(&sorted, 0.01, 1e-6);
        // 1000 excesses placed evenly: their mean is right to about ln(1000)/1000.
        assert!((far - 1e6_f64.ln()).abs() < 0.05, "{far}");
    }
}
