//! Loggers that are not perfect: coarse steps, a short range, a jittering clock, holes.

use serde::{Deserialize, Serialize};

use super::random::Random;

/// What a logger makes of the values.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Logger {
    /// Step of each output, in its unit; 0 for a fine one.
    pub steps: Vec<f64>,
    /// Lowest and highest value of each output that can be logged, where there are any.
    pub ranges: Vec<Option<[f64; 2]>>,
    /// Standard deviation of the time at which a sample is taken, in sample times.
    pub jitter: f64,
    /// Share of the values of outputs that are missing, in bursts.
    pub missing: f64,
    /// Share of the rows that are lost, one at a time.
    pub lost: f64,
    /// Seed of what is random.
    pub seed: u64,
}

/// Mean length of a burst of missing values, in samples.
const BURST: f64 = 6.0;
/// A row can only be lost where no input has moved by more than this share of its spread since the
/// row before: else what the plant saw is in no log.
const STILL: f64 = 0.02;

/// What a logger does to one run.
pub(super) struct Logged {
    /// Outputs, row by row, NaN where they are missing.
    pub y: Vec<f64>,
    /// Whether each row is there at all.
    pub is_kept: Vec<bool>,
}

impl Logger {
    /// Labels of what the logger does to an output, as the library calls it: who names these is
    /// right, too.
    #[must_use]
    pub fn labels(&self, output: usize) -> Vec<&'static str> {
        let mut all = Vec::new();
        if self.ranges.get(output).is_some_and(Option::is_some) {
            all.push("sensor-saturation");
        }
        if 0.0 < self.jitter {
            all.push("sensor-jitter");
        }
        all
    }

    /// Standard deviation of an output's error by its steps and by the clock, where it moves by
    /// `slope` per sample (root mean square).
    pub(super) fn noise(&self, output: usize, slope: f64) -> f64 {
        let step = self.steps.get(output).copied().unwrap_or(0.0);
        f64::hypot(step / 12.0_f64.sqrt(), self.jitter * slope)
    }

    /// Logs a run. With `is_blurred` values are rounded and taken at wrong times; what is out of
    /// range is then at its end, else it is missing, as all that is known of it is that.
    pub(super) fn log(
        &self,
        y: &[f64],
        u: &[f64],
        ny: usize,
        run: u64,
        is_blurred: bool,
    ) -> Logged {
        let n = y.len() / ny.max(1);
        let mut all = y.to_vec();
        let clock = &mut Random::named(self.seed, &format!("clock/{run}"));
        for k in 0..n {
            let off = self.jitter * clock.normal();
            for c in 0..ny {
                let at = |k: usize| y[k.min(n - 1) * ny + c];
                let mut value = at(k);
                if is_blurred {
                    value += off * 0.5 * (at(k + 1) - at(k.saturating_sub(1)));
                }
                if let Some(Some([low, high])) = self.ranges.get(c) {
                    let is_out = value < *low || *high < value;
                    value = match (is_out, is_blurred) {
                        (true, false) => f64::NAN,
                        _ => value.clamp(*low, *high),
                    };
                }
                if let Some(step) = self.steps.get(c).filter(|step| is_blurred && 0.0 < **step) {
                    value = step * (value / step).round();
                }
                all[k * ny + c] = value;
            }
        }
        self.punch(&mut all, ny, run);
        Logged { y: all, is_kept: self.kept(u, n, run) }
    }

    /// Bursts of missing values, channel by channel.
    fn punch(&self, y: &mut [f64], ny: usize, run: u64) {
        for c in 0..ny {
            let random = &mut Random::named(self.seed, &format!("missing/{run}/{c}"));
            let mut left = 0.0;
            for value in y.iter_mut().skip(c).step_by(ny) {
                if left < 1.0 && random.unit() < self.missing / BURST {
                    left = -BURST * (1.0 - random.unit()).ln() + 1.0;
                }
                if 1.0 <= left {
                    left -= 1.0;
                    *value = f64::NAN;
                }
            }
        }
    }

    fn kept(&self, u: &[f64], n: usize, run: u64) -> Vec<bool> {
        let nu = u.len() / n.max(1);
        let spread = |i: usize| {
            let column = || u.iter().skip(i).step_by(nu);
            let mean = column().sum::<f64>() / n as f64;
            (column().map(|v| (v - mean).powi(2)).sum::<f64>() / n as f64).sqrt()
        };
        let spreads: Vec<f64> = (0..nu).map(spread).collect();
        let random = &mut Random::named(self.seed, &format!("lost/{run}"));
        let mut is_before = true;
        let kept = (0..n).map(|k| {
            let is_hit = random.unit() < self.lost;
            let is_inner = 0 < k && k + 1 < n;
            let is_still = is_inner
                && (0..nu)
                    .all(|i| (u[k * nu + i] - u[(k - 1) * nu + i]).abs() <= STILL * spreads[i]);
            is_before = !(is_hit && is_still && is_before);
            is_before
        });
        kept.collect()
    }
}
