//! The budget of a diagnosis.

use std::{
    fmt::{self, Display, Formatter},
    str::FromStr,
    time::Duration,
};

/// What a diagnosis may cost: time, or runs of the simulator through the logs.
///
/// ```
/// use std::time::Duration;
///
/// use fdiag::gap_study::Budget;
///
/// assert_eq!("300runs".parse(), Ok(Budget::Runs(300)));
/// assert_eq!("1.5min".parse(), Ok(Budget::Time(Duration::from_secs(90))));
/// assert!("300".parse::<Budget>().is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Budget {
    /// So many runs through all logs that are fitted.
    Runs(u64),
    /// So long in the simulator.
    Time(Duration),
}

/// Units of time with their seconds, the longer name first where one begins another.
const UNITS: [(&str, f64); 4] = [("min", 60.0), ("ms", 1e-3), ("h", 3600.0), ("s", 1.0)];

impl Budget {
    /// Runs that it allows, where one takes so many seconds.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
    pub(super) fn runs(self, seconds: f64) -> u64 {
        match self {
            Self::Runs(runs) => runs,
            Self::Time(time) => (time.as_secs_f64() / seconds.max(1e-9)) as u64,
        }
    }
}

impl FromStr for Budget {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong =
            || format!("expected a time such as `10min` or runs such as `300runs`, found `{text}`");
        if let Some(runs) = text.strip_suffix("runs") {
            return runs.trim().parse().map(Self::Runs).map_err(|_| wrong());
        }
        let unit = UNITS.iter().find_map(|(unit, s)| Some((text.strip_suffix(unit)?, s)));
        let (number, unit) = unit.ok_or_else(wrong)?;
        let seconds = number.trim().parse::<f64>().map_err(|_| wrong())? * unit;
        Duration::try_from_secs_f64(seconds).map(Self::Time).map_err(|_| wrong())
    }
}

impl Display for Budget {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Runs(runs) => write!(f, "{runs} runs"),
            Self::Time(time) => write!(f, "{} s", time.as_secs_f64()),
        }
    }
}
