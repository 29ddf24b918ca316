//! What the time base of a log is like.

use serde::Serialize;

/// Steps longer than this many median steps are gaps, as in resampling by default.
const GAP_STEPS: f64 = 5.0;
/// Share of a step by which an even clock may be off, as in resampling by default.
const EVEN: f64 = 1e-3;

/// A time base, in seconds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClockInfo {
    /// The column of time; empty where it is the clock of the recording.
    pub column: String,
    /// First time.
    pub first_s: f64,
    /// Last time.
    pub last_s: f64,
    /// Median step between rows that follow each other; NaN for fewer than two.
    pub median_step_s: f64,
    /// Shortest step forward.
    pub shortest_step_s: f64,
    /// Longest step.
    pub longest_step_s: f64,
    /// Steps of more than five median steps.
    pub gaps: usize,
    /// Rows whose time is that of the row before.
    pub duplicates: usize,
    /// Rows whose time is before that of the row before.
    pub backwards: usize,
    /// Rows without a time.
    pub missing: usize,
    /// Whether all steps are the median step, within a thousandth.
    pub is_even: bool,
    /// What should be looked at before it is trusted.
    pub doubts: Vec<String>,
}

impl ClockInfo {
    pub(super) fn new(column: &str, mut times: Vec<f64>) -> Self {
        let rows = times.len();
        times.retain(|time| time.is_finite());
        let steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let mut forward: Vec<f64> = steps.iter().copied().filter(|step| *step > 0.0).collect();
        forward.sort_by(f64::total_cmp);
        let at =
            |place: Option<usize>| place.and_then(|i| forward.get(i)).copied().unwrap_or(f64::NAN);
        let median = at(Some(forward.len() / 2));
        let of = |is: &dyn Fn(f64) -> bool| steps.iter().filter(|step| is(**step)).count();
        let mut clock = Self {
            column: column.to_owned(),
            first_s: times.first().copied().unwrap_or(f64::NAN),
            last_s: times.last().copied().unwrap_or(f64::NAN),
            median_step_s: median,
            shortest_step_s: at(Some(0)),
            longest_step_s: at(forward.len().checked_sub(1)),
            gaps: of(&|step| step > GAP_STEPS * median),
            duplicates: of(&|step| (0.0..=0.0).contains(&step)),
            backwards: of(&|step| step < 0.0),
            missing: rows - times.len(),
            is_even: of(&|step| (step - median).abs() > EVEN * median) == 0 && !steps.is_empty(),
            doubts: Vec::new(),
        };
        clock.doubt();
        clock
    }

    fn doubt(&mut self) {
        let mut doubt = |count: usize, what: &str| {
            if count > 0 {
                self.doubts.push(format!("{count} {what}"));
            }
        };
        doubt(self.missing, "rows have no time");
        doubt(self.duplicates, "rows have the time of the row before");
        doubt(self.backwards, "rows go back in time: several runs in one file?");
        doubt(self.gaps, "gaps");
    }

    /// Doubts that a time without a unit is in seconds: clocks since 1970 are large numbers, days of a spreadsheet have
    /// steps that are whole seconds as days and no whole milliseconds as seconds, and few clocks that count from a start
    /// count for a year.
    pub(super) fn doubt_seconds(&mut self) {
        let units = [(1e17, "ns"), (1e14, "us"), (1e11, "ms")];
        let since = units.into_iter().find(|(least, _)| self.first_s >= *least);
        if let Some((_, unit)) = since {
            self.doubts.push(format!(
                "times of this size are {unit} since 1970, and no unit is stated: say `time.unit = \"{unit}\"`"
            ));
        } else if self.counts_days() {
            let step = (86_400.0 * self.median_step_s).round();
            self.doubts.push(format!(
                "days of a spreadsheet? As days the rows are {step} s apart: say `time.unit = \"day\"`"
            ));
        } else if self.first_s < 1e9
            && self.median_step_s >= 1.0
            && self.last_s - self.first_s > 31_536_000.0
        {
            self.doubts
                .push("more than a year, if these are seconds: another `time.unit`?".to_owned());
        }
    }
}

impl ClockInfo {
    /// Whether times may be days since 1899-12-30, between the years 1970 and 2100.
    fn counts_days(&self) -> bool {
        let is_whole =
            |number: f64| number.round() >= 1.0 && (number - number.round()).abs() < 0.01;
        (25_569.0..73_051.0).contains(&self.first_s)
            && is_whole(86_400.0 * self.median_step_s)
            && !is_whole(1e3 * self.median_step_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_measured_and_what_is_odd_is_counted() {
        let clock = ClockInfo::new("t", vec![0.0, 1.0, 2.0, 2.0, 3.0, f64::NAN, 13.0, 12.0, 13.0]);
        assert_eq!((clock.gaps, clock.duplicates, clock.backwards, clock.missing), (1, 1, 1, 1));
        assert_eq!((clock.median_step_s, clock.longest_step_s), (1.0, 10.0));
        assert!(!clock.is_even && clock.doubts.len() == 4);
        assert!(ClockInfo::new("t", vec![0.0, 0.1, 0.2]).is_even);
        assert!(ClockInfo::new("t", vec![]).median_step_s.is_nan());
    }

    #[test]
    fn epochs_in_small_units_are_suspected() {
        for (first, unit) in [(1.76e12, "ms"), (1.76e15, "us"), (1.76e18, "ns")] {
            let mut clock = ClockInfo::new("t", vec![first, first * 1.000_001]);
            clock.doubt_seconds();
            assert!(clock.doubts[0].contains(&format!("\"{unit}\"")), "{:?}", clock.doubts);
        }
        let doubts = |times: Vec<f64>| {
            let mut clock = ClockInfo::new("t", times);
            clock.doubt_seconds();
            clock.doubts
        };
        // The second of them is seconds since 1970 for two years, and the last are seconds since midnight.
        for fine in
            [[1.76e9, 1.76e9 + 0.1], [1.7e9, 1.76e9], [45_323.5, 45_323.51], [45_323.0, 45_324.0]]
        {
            assert_eq!(doubts(fine.to_vec()), Vec::<String>::new(), "{fine:?}");
        }
        let days = doubts(vec![45_323.999_305_56, 45_323.999_652_78, 45_324.0, 45_324.000_347_22]);
        assert!(days[0].contains("30 s apart") && days[0].contains("\"day\""), "{days:?}");
        assert!(doubts(vec![0.0, 4e7])[0].contains("more than a year"));
    }
}
