//! How long a user waits, and what is too much to begin without being asked.

use std::time::Duration;

use clap::Args;
use fdiag::{gap_study::Budget, model::duration};

/// Work that takes longer is announced …
const TOLD: f64 = 120.0;
/// … and beyond half an hour begun only with `--yes`.
const LARGE: f64 = 1800.0;
/// The same of memory, in bytes.
const TOLD_BYTES: f64 = 5e8;
const LARGE_BYTES: f64 = 2e9;

/// How long a user waits.
#[derive(Clone, Debug, Default, Args)]
pub struct PatienceArgs {
    /// Stop after this long (`90s`, `10min`, `2h`), with what there is by then
    #[arg(long, value_name = "TIME", value_parser = time)]
    pub time_limit: Option<Duration>,
    /// Begin also what will take very long, or much memory
    #[arg(long)]
    pub yes: bool,
}

/// What somebody is told before work goes on that takes long.
#[derive(Debug, PartialEq, Eq)]
pub enum Plan {
    /// It is not worth a word.
    Short,
    /// It goes on, and the user knows for how long.
    Told(String),
    /// It is so large that somebody has to want it.
    Refused(String),
}

impl PatienceArgs {
    /// What is said of work that will take so many seconds more and so many bytes.
    #[must_use]
    pub fn plan(&self, seconds: f64, bytes: f64) -> Plan {
        let time = format!("about {}", duration(rounded(seconds)));
        let cost = match bytes {
            bytes if TOLD_BYTES < bytes => format!("{time}, {:.1} GB", bytes / 1e9),
            _ => time,
        };
        let ends = self.time_limit.is_some_and(|limit| limit.as_secs_f64() < LARGE);
        let is_long = LARGE < seconds && !ends;
        if !self.yes && (is_long || LARGE_BYTES < bytes) {
            return Plan::Refused(cost);
        }
        if TOLD < seconds || TOLD_BYTES < bytes { Plan::Told(cost) } else { Plan::Short }
    }
}

/// Two figures: no estimate is better.
fn rounded(seconds: f64) -> f64 {
    let unit = match seconds {
        s if s < 120.0 => 1.0,
        s if s < 7200.0 => 60.0,
        _ => 3600.0,
    };
    let number = seconds / unit;
    let step = if number < 10.0 { 0.1 } else { 1.0 };
    (number / step).round() * step * unit
}

/// A time above zero.
pub(crate) fn time(text: &str) -> Result<Duration, String> {
    match text.parse::<Budget>() {
        Ok(Budget::Time(time)) if !time.is_zero() => Ok(time),
        _ => {
            Err("expected a time above 0 with its unit, such as `90s`, `10min` or `2h`".to_owned())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_large_has_to_be_wanted() {
        let plain = PatienceArgs::default();
        assert_eq!(plain.plan(60.0, 0.0), Plan::Short);
        assert_eq!(plain.plan(612.0, 0.0), Plan::Told("about 10 min".to_owned()));
        assert_eq!(plain.plan(2400.0, 3e9), Plan::Refused("about 40 min, 3.0 GB".to_owned()));
        assert_eq!(plain.plan(9300.0, 0.0), Plan::Refused("about 2.6 h".to_owned()));
        let yes = PatienceArgs { yes: true, ..plain.clone() };
        assert_eq!(yes.plan(9300.0, 3e9), Plan::Told("about 2.6 h, 3.0 GB".to_owned()));
        // What ends soon needs no leave, unless it does not fit.
        let limited = PatienceArgs { time_limit: Some(Duration::from_secs(600)), ..plain };
        assert!(matches!(limited.plan(9300.0, 0.0), Plan::Told(_)));
        assert!(matches!(limited.plan(9300.0, 3e9), Plan::Refused(_)));
    }

    #[test]
    fn times_have_a_unit() {
        assert_eq!(time("10min"), Ok(Duration::from_secs(600)));
        for wrong in ["10", "0s", "300runs", "-1s", "NaNs", "1e30h", ""] {
            assert!(time(wrong).is_err(), "{wrong}");
        }
    }
}
