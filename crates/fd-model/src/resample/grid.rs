//! The even time base of a series, and where its times fall among the samples.

use fd_core::Resource;

use crate::{
    domain::SampleTime,
    resample::{Disorder, Gap, ResamplePolicy, TimeBaseError, TimeBaseReport},
};

const BRIDGED_STEPS: f64 = 5.0;
/// Part of the last digit of a time that is rounding of binary numbers.
const EXACT: f64 = 1e-3;
/// Most digits after the point that are looked for.
const DIGITS: i32 = 9;

/// The samples that move time forward.
pub(super) struct Order {
    pub kept: Vec<usize>,
    duplicates: usize,
    backwards: usize,
}

impl Order {
    pub(super) fn of(t: &[f64], disorder: Disorder) -> Result<Self, TimeBaseError> {
        let mut order = Self { kept: Vec::with_capacity(t.len()), duplicates: 0, backwards: 0 };
        let mut before = f64::NEG_INFINITY;
        for (index, &time) in t.iter().enumerate() {
            if !time.is_finite() {
                return Err(TimeBaseError::NonFinite { index, time });
            }
            if before < time {
                order.kept.push(index);
                before = time;
            } else if disorder == Disorder::Reject {
                return Err(TimeBaseError::NotIncreasing { index, before, time });
            } else if time < before {
                order.backwards += 1;
            } else {
                order.duplicates += 1;
            }
        }
        Ok(order)
    }
}

/// The even time base, and what it was made from.
pub(super) struct Grid {
    pub start: f64,
    pub step: SampleTime,
    pub samples: usize,
    max_gap: f64,
    tolerance: f64,
    shortest: f64,
    median: f64,
    longest: f64,
    jitter: f64,
    gaps: Vec<Gap>,
}

/// Where a grid time falls among the samples.
pub(super) enum Place {
    On(usize),
    Between { before: usize, after: usize, share: f64 },
    Gap,
}

/// What the last digit counts with which the times are written, in seconds: all are multiples of it. `None` where there are
/// too many digits to tell.
fn last_digit(kept: &[usize], t: &[f64]) -> Option<f64> {
    let is_written = |digits: &i32| {
        let per_second = 10.0_f64.powi(*digits);
        kept.iter().all(|&i| {
            let count = t[i] * per_second;
            (count - count.round()).abs() <= EXACT && count.abs() * f64::EPSILON < EXACT
        })
    };
    (0..=DIGITS).find(is_written).map(|digits| 10.0_f64.powi(-digits))
}

impl Grid {
    pub(super) fn of(
        kept: &[usize],
        t: &[f64],
        policy: &ResamplePolicy,
    ) -> Result<Self, TimeBaseError> {
        let (Some(&first), Some(&last)) = (kept.first(), kept.last()) else {
            return Err(TimeBaseError::TooShort { samples: 0 });
        };
        let (start, span) = (t[first], t[last] - t[first]);
        let mut steps: Vec<f64> = kept.windows(2).map(|pair| t[pair[1]] - t[pair[0]]).collect();
        steps.sort_unstable_by(f64::total_cmp);
        let mean = span / steps.len().max(1) as f64;
        // Times that are rounded or cut off say no more than their last digit does.
        let digit = last_digit(kept, t).map(|digit| (1.0 + EXACT) * digit);
        let digit = digit.filter(|digit| 2.0 * digit < mean).unwrap_or(0.0);
        let is_on_grid = |step: f64| {
            let off = (policy.tolerance * step).max(digit);
            kept.iter().enumerate().all(|(k, &i)| (t[i] - (start + k as f64 * step)).abs() <= off)
        };
        let step = match (policy.sample_time, steps.get(steps.len() / 2)) {
            (Some(step), _) => step,
            (None, None) => return Err(TimeBaseError::TooShort { samples: kept.len() }),
            (None, Some(&median)) => {
                if is_on_grid(mean) {
                    mean
                } else {
                    median
                }
            }
        };
        let digit = if is_on_grid(step) { digit } else { 0.0 };
        let tolerance = (policy.tolerance * step).max(digit);
        let samples = ((span + tolerance) / step).floor() + 1.0;
        let limit = policy.limits.check(Resource::Samples, "samples on an even time base", samples);
        if let Err(limit) = limit {
            let length = |pair: &&[usize]| t[pair[1]] - t[pair[0]];
            let longest = kept.windows(2).max_by(|a, b| length(a).total_cmp(&length(b)));
            return Err(TimeBaseError::TooLong {
                span_s: span,
                step_s: step,
                longest_s: longest.as_ref().map_or(0.0, length),
                longest_at_s: longest.map_or(start, |pair| t[pair[0]]),
                limit,
            });
        }
        let median = steps.get(steps.len() / 2).copied().unwrap_or(step);
        let bridged = policy.max_gap_s.unwrap_or(BRIDGED_STEPS * step.max(median));
        let max_gap = bridged + tolerance;
        let bridged = steps.iter().filter(|&&dt| dt <= max_gap);
        let gaps = kept.windows(2).map(|pair| Gap { from_s: t[pair[0]], to_s: t[pair[1]] });
        Ok(Self {
            start,
            step: SampleTime::new(step)?,
            // Checked against the limit above.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            samples: samples as usize,
            max_gap,
            tolerance,
            shortest: steps.first().copied().unwrap_or(step),
            median,
            longest: steps.last().copied().unwrap_or(step),
            jitter: bridged.map(|dt| (dt - median).abs()).fold(0.0, f64::max),
            gaps: gaps.filter(|gap| max_gap < gap.to_s - gap.from_s).collect(),
        })
    }

    /// Where grid time `k` falls; `cursor` is the place among `kept` of the sample before, starts
    /// at 0 and only moves forward with `k`.
    pub(super) fn place(&self, k: usize, cursor: &mut usize, kept: &[usize], t: &[f64]) -> Place {
        let time = self.start + k as f64 * self.step.seconds();
        while *cursor + 1 < kept.len() && t[kept[*cursor + 1]] <= time + self.tolerance {
            *cursor += 1;
        }
        let before = kept[*cursor];
        match kept.get(*cursor + 1) {
            Some(&after) if self.tolerance < time - t[before] => {
                let length = t[after] - t[before];
                if self.max_gap < length {
                    Place::Gap
                } else {
                    Place::Between { before, after, share: (time - t[before]) / length }
                }
            }
            _ => Place::On(before),
        }
    }

    /// What samples after the one at `cursor` are held before the next grid time, each with its share of the time from
    /// grid time `k` until the end of its own: what a running mean gives it. Nothing is held through a gap.
    pub(super) fn held(
        &self,
        k: usize,
        cursor: usize,
        kept: &[usize],
        t: &[f64],
        mut visit: impl FnMut(usize, f64),
    ) {
        let begin = self.start + k as f64 * self.step.seconds();
        let end = begin + self.step.seconds();
        for place in cursor + 1..kept.len() {
            let [before, now] = [t[kept[place - 1]], t[kept[place]]];
            if end - self.tolerance <= now || self.max_gap < now - before {
                return;
            }
            let until = kept.get(place + 1).map_or(end, |next| t[*next].min(end));
            visit(kept[place], (until - now) / (until - begin));
        }
    }

    pub(super) fn report(self, order: &Order, even: bool, rows: usize) -> TimeBaseReport {
        TimeBaseReport {
            rows,
            duplicates: order.duplicates,
            out_of_order: order.backwards,
            shortest_step_s: self.shortest,
            median_step_s: self.median,
            longest_step_s: self.longest,
            jitter_s: self.jitter,
            gaps: self.gaps,
            even,
            step_s: self.step.seconds(),
            samples: self.samples,
        }
    }
}
