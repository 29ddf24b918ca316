//! Alarms and delays of recorded statistics.

use std::collections::VecDeque;

use fd_core::stage::Phase;

use crate::decide::{Debounce, Debouncing, RuleError};

/// The `raise`-th largest of the last `out_of` statistics: it exceeds a threshold exactly when the
/// raise condition of `debouncing` holds. The window begins empty.
///
/// ```
/// use fd_compensate::{decide::Debouncing, evaluate::debounced_statistics};
///
/// let two_in_a_row = debounced_statistics(&[1.0, 3.0, 2.0, 5.0], Debouncing::consecutive(2));
/// assert_eq!(two_in_a_row[1..], [1.0, 2.0, 2.0]);
/// ```
#[must_use]
pub fn debounced_statistics(statistics: &[f64], debouncing: Debouncing) -> Vec<f64> {
    let mut window = DebouncedStatistic::new(debouncing);
    statistics.iter().map(|&statistic| window.add(statistic)).collect()
}

/// [`debounced_statistics`] sample by sample.
///
/// ```
/// use fd_compensate::{decide::Debouncing, evaluate::DebouncedStatistic};
///
/// let mut two_in_a_row = DebouncedStatistic::new(Debouncing::consecutive(2));
/// two_in_a_row.add(1.0);
/// assert_eq!([3.0, 2.0].map(|statistic| two_in_a_row.add(statistic)), [1.0, 2.0]);
/// ```
#[derive(Clone, Debug)]
pub struct DebouncedStatistic {
    raise: usize,
    out_of: usize,
    recent: VecDeque<f64>,
    /// The recent ones in order.
    sorted: Vec<f64>,
}

impl DebouncedStatistic {
    /// An empty window.
    #[must_use]
    pub fn new(debouncing: Debouncing) -> Self {
        let count = |n: u64| usize::try_from(n).unwrap_or(usize::MAX);
        let (raise, out_of) = (count(debouncing.raise), count(debouncing.out_of));
        Self { raise, out_of, recent: VecDeque::new(), sorted: Vec::new() }
    }

    /// Empties the window.
    pub fn reset(&mut self) {
        self.recent.clear();
    }

    /// Takes a statistic in and returns the one that counts.
    pub fn add(&mut self, statistic: f64) -> f64 {
        if self.out_of <= 1 {
            return statistic;
        }
        if self.recent.len() >= self.out_of {
            self.recent.pop_front();
        }
        self.recent.push_back(statistic);
        self.sorted.clear();
        self.sorted.extend(&self.recent);
        self.sorted.sort_unstable_by(f64::total_cmp);
        let at = self.sorted.len().checked_sub(self.raise);
        at.map_or(f64::NEG_INFINITY, |i| self.sorted[i])
    }
}

/// Replays a rule that was just reset over statistics of the compensating phase: whether each sample
/// is in alarm.
///
/// ```
/// use fd_compensate::{decide::Debouncing, evaluate::alarms};
///
/// let replay = alarms(&[0.0, 2.0, 2.0, 0.0], 1.0, Debouncing::default())?;
/// assert_eq!(replay, [false, true, true, false]);
/// # Ok::<(), fd_compensate::decide::RuleError>(())
/// ```
///
/// # Errors
///
/// Returns an error when the debouncing is malformed.
pub fn alarms(
    statistics: &[f64],
    threshold: f64,
    debouncing: Debouncing,
) -> Result<Vec<bool>, RuleError> {
    let mut rule = Debounce::new(1, debouncing)?;
    let judged = (0..)
        .zip(statistics)
        .map(|(k, &statistic)| rule.judge(k, Phase::Compensating, threshold < statistic).is_some());
    Ok(judged.collect())
}

/// Share of fault-free samples in alarm; 0 of none.
///
/// ```
/// use fd_compensate::{decide::Debouncing, evaluate::false_alarm_rate};
///
/// let rate = false_alarm_rate(&[0.0, 2.0, 0.5, 0.1], 1.0, Debouncing::default())?;
/// assert_eq!(rate, 0.25);
/// # Ok::<(), fd_compensate::decide::RuleError>(())
/// ```
///
/// # Errors
///
/// Returns an error when the debouncing is malformed.
pub fn false_alarm_rate(
    statistics: &[f64],
    threshold: f64,
    debouncing: Debouncing,
) -> Result<f64, RuleError> {
    let replay = alarms(statistics, threshold, debouncing)?;
    let raised = replay.iter().filter(|&&alarm| alarm).count();
    Ok(raised as f64 / replay.len().max(1) as f64)
}

/// Samples from the start of a fault at sample `fault_at` to its alarm; `None` if it is never raised.
///
/// The rule is reset at `fault_at`, so that neither a false alarm before the fault nor alarming samples
/// before it shorten the delay.
///
/// ```
/// use fd_compensate::{decide::Debouncing, evaluate::detection_delay};
///
/// let statistics = [0.0, 2.0, 0.5, 2.0, 2.0];
/// assert_eq!(detection_delay(&statistics, 1.0, Debouncing::consecutive(2), 2)?, Some(2));
/// # Ok::<(), fd_compensate::decide::RuleError>(())
/// ```
///
/// # Errors
///
/// Returns an error when the debouncing is malformed.
pub fn detection_delay(
    statistics: &[f64],
    threshold: f64,
    debouncing: Debouncing,
    fault_at: usize,
) -> Result<Option<usize>, RuleError> {
    let after = statistics.get(fault_at..).unwrap_or_default();
    Ok(alarms(after, threshold, debouncing)?.iter().position(|&alarm| alarm))
}
