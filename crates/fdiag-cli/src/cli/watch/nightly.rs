//! Which units have moved away from their model for a long time: recent samples and how the residual grows.

use std::collections::{HashMap, VecDeque};

use fd_watch::{Doing, Row, UnitStatus};

/// Most bytes of recent samples of all units together; further units have none.
const MOST: usize = 256 << 20;
/// Periods, one after another, in which the residual has to have grown.
const RISES: usize = 3;
/// How much it has to have grown over them.
const GROWTH: f64 = 1.3;

/// The last samples of each unit, and how its residual is from period to period.
pub(super) struct Nightly {
    period: f64,
    samples: usize,
    units: HashMap<String, Recent>,
    /// Whether a unit had to do without.
    pub is_full: bool,
}

/// A stretch of one unit that should be looked at.
#[derive(Debug, PartialEq)]
pub(super) struct Stretch {
    pub unit: String,
    /// Time of the newest sample, in s.
    pub time: f64,
    /// Rows of time and values, one after another.
    pub rows: Vec<f64>,
}

#[derive(Default)]
struct Recent {
    rows: VecDeque<f64>,
    /// End of the present period, in s.
    until: Option<f64>,
    sum: f64,
    count: u32,
    /// Mean of statistic over threshold in the last periods, oldest first.
    means: VecDeque<f64>,
}

impl Nightly {
    /// Periods of so many seconds, and so many recent samples of each unit.
    pub(super) fn new(period: f64, samples: u32) -> Self {
        let samples = usize::try_from(samples).unwrap_or(usize::MAX);
        Self { period, samples, units: HashMap::new(), is_full: false }
    }

    /// Takes a sample that was judged, and hands out the recent ones when the residual has grown for long.
    pub(super) fn take(&mut self, row: Row<'_>, status: UnitStatus<'_>) -> Option<Stretch> {
        let width = 1 + row.values.len();
        if !self.units.contains_key(row.unit) {
            let bytes = (size_of::<f64>() * width).saturating_mul(self.samples);
            if MOST < bytes.saturating_mul(self.units.len() + 1) {
                self.is_full = true;
                return None;
            }
            self.units.insert(row.unit.to_owned(), Recent::default());
        }
        let recent = self.units.get_mut(row.unit)?;
        let newest = recent.rows.len().checked_sub(width).and_then(|at| recent.rows.get(at));
        // What the clock leaves out is no part of a log either.
        if newest.is_some_and(|newest| row.time <= *newest) {
            return None;
        }
        if self.samples * width <= recent.rows.len() {
            recent.rows.drain(..width);
        }
        recent.rows.push_back(row.time);
        recent.rows.extend(row.values);
        if matches!(status.doing, Doing::Watched | Doing::Alarmed) {
            let share = status.latest.statistic / status.latest.threshold;
            if share.is_finite() {
                recent.sum += share;
                recent.count += 1;
            }
        }
        let until = *recent.until.get_or_insert(row.time + self.period);
        if row.time < until {
            return None;
        }
        recent.until = Some(row.time + self.period);
        recent.has_grown().then(|| Stretch {
            unit: row.unit.to_owned(),
            time: row.time,
            rows: recent.rows.iter().copied().collect(),
        })
    }
}

impl Recent {
    /// Ends a period: whether the residual has grown in several of them.
    fn has_grown(&mut self) -> bool {
        let (sum, count) = (std::mem::take(&mut self.sum), std::mem::take(&mut self.count));
        if count == 0 {
            self.means.clear();
            return false;
        }
        self.means.push_back(sum / f64::from(count));
        if RISES + 1 < self.means.len() {
            self.means.pop_front();
        }
        let rises = self.means.iter().zip(self.means.iter().skip(1)).filter(|(a, b)| a < b).count();
        let (first, last) = (self.means.front(), self.means.back());
        let grown = first.zip(last).is_some_and(|(first, last)| GROWTH * first < *last);
        let has_grown = rises == RISES && grown;
        if has_grown {
            // It is looked at once, and again only when it has grown further.
            self.means.drain(..RISES);
        }
        has_grown
    }
}

#[cfg(test)]
mod tests {
    use fd_watch::Latest;

    use super::*;

    fn feed(nightly: &mut Nightly, shares: &[f64]) -> Vec<(usize, Stretch)> {
        let mut found = Vec::new();
        for (k, &statistic) in shares.iter().enumerate() {
            let latest = Latest { time: 0.0, statistic, threshold: 1.0 };
            let status = UnitStatus { name: "p", doing: Doing::Watched, latest, wish: None };
            let row = Row { unit: "p", time: k as f64, values: &[k as f64] };
            found.extend(nightly.take(row, status).map(|stretch| (k, stretch)));
        }
        found
    }

    #[test]
    fn a_residual_that_grows_for_several_periods_is_looked_at_once() {
        let grows: Vec<f64> = (0..100).map(|k| 0.1 + 0.002 * f64::from(k)).collect();
        let found = feed(&mut Nightly::new(10.0, 5), &grows);
        let at: Vec<usize> = found.iter().map(|(k, _)| *k).collect();
        // Four periods make three rises; after that three more periods.
        assert_eq!(at, [40, 70], "by a third each time");
        assert_eq!(found[0].1.rows, [36.0, 36.0, 37.0, 37.0, 38.0, 38.0, 39.0, 39.0, 40.0, 40.0]);
        let stays: Vec<f64> = (0..1000).map(|k| 0.5 + 0.1 * f64::from(k).sin()).collect();
        assert_eq!(feed(&mut Nightly::new(10.0, 5), &stays), []);
    }

    #[test]
    fn memory_is_bounded_whatever_the_number_of_units() {
        let mut nightly = Nightly::new(10.0, 1 << 23);
        let latest = Latest::default();
        for unit in ["a", "b", "c"] {
            let status = UnitStatus { name: unit, doing: Doing::Watched, latest, wish: None };
            nightly.take(Row { unit, time: 0.0, values: &[0.0] }, status);
        }
        assert!(nightly.is_full && nightly.units.len() == 2, "128 MiB each");
    }
}
