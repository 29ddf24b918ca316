//! The debounced alarm: some of the last samples must agree before a fault is reported.

use fd_core::{
    Scalar, StateVisitor,
    stage::{Decision, DecisionRule, Evidence, Fault, Phase, Stage},
};
use serde::{Deserialize, Serialize};

use super::error::RuleError;

/// How many samples must agree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Debouncing {
    /// Alarming samples among the last `out_of` that raise the alarm.
    pub raise: u64,
    /// Window of `raise`; equal to it for consecutive samples.
    pub out_of: u64,
    /// Samples in a row without alarm that clear it.
    pub clear: u64,
    /// Whether a raised alarm stays until the rule is reset, also through a training.
    pub latch: bool,
}

/// Longest memory of a rule, in samples: more is a mistake in the settings, not a debounce.
const MOST_SAMPLES: u64 = 1_000_000;

impl Default for Debouncing {
    /// Every sample speaks for itself.
    fn default() -> Self {
        Self { raise: 1, out_of: 1, clear: 1, latch: false }
    }
}

impl Debouncing {
    /// `count` alarming samples in a row raise the alarm, as many normal ones clear it.
    #[must_use]
    pub const fn consecutive(count: u64) -> Self {
        Self { raise: count, out_of: count, clear: count, latch: false }
    }

    /// Checks the counts.
    ///
    /// # Errors
    ///
    /// Returns the first count that is out of its range.
    pub fn check(&self) -> Result<(), RuleError> {
        let Self { raise, out_of, clear, .. } = *self;
        let refuse =
            |parameter, expected, found| Err(RuleError::Count { parameter, expected, found });
        if raise == 0 {
            return refuse("raise", "at least 1", raise);
        }
        if out_of > MOST_SAMPLES {
            return refuse("out_of", "at most a million samples", out_of);
        }
        if out_of < raise {
            return refuse("out_of", "at least as large as raise", out_of);
        }
        if clear == 0 {
            return refuse("clear", "at least 1", clear);
        }
        Ok(())
    }
}

/// Reports a fault when `raise` of the last `out_of` samples alarmed.
///
/// `since` is the first of those samples. No size is estimated.
#[derive(Clone, Debug)]
pub struct Debounce {
    residual_len: usize,
    debouncing: Debouncing,
    /// Whether each of the last `out_of` samples alarmed, in a ring.
    recent: Vec<u64>,
    next: u64,
    normal_in_a_row: u64,
    /// Sample of the first alarm that led to the present fault, plus one; 0 while nominal.
    raised: u64,
}

impl Debounce {
    /// A rule for `residual_len` channels.
    ///
    /// ```
    /// use fd_compensate::decide::{Debounce, Debouncing};
    /// use fd_core::stage::{DecisionRule, Evidence, Phase, Verdict};
    ///
    /// let mut rule = Debounce::new(1, Debouncing::consecutive(2))?;
    /// let verdict = Verdict { statistic: 2.0, threshold: 1.0 };
    /// let at = |k| Evidence { k, phase: Phase::Compensating, verdict, r_star: &[2.0] };
    /// assert!(!rule.decide(at(0)).is_fault());
    /// assert!(rule.decide(at(1)).is_fault());
    /// # Ok::<(), fd_compensate::decide::RuleError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when a count is out of its range.
    pub fn new(residual_len: usize, debouncing: Debouncing) -> Result<Self, RuleError> {
        debouncing.check()?;
        let Ok(window) = usize::try_from(debouncing.out_of) else {
            let (parameter, expected) = ("out_of", "small enough for this machine");
            return Err(RuleError::Count { parameter, expected, found: debouncing.out_of });
        };
        let recent = vec![0; window];
        Ok(Self { residual_len, debouncing, recent, next: 0, normal_in_a_row: 0, raised: 0 })
    }

    /// Takes note of one sample and returns the first alarm of the present fault, if there is one.
    pub(crate) fn judge(&mut self, k: u64, phase: Phase, alarm: bool) -> Option<u64> {
        if phase == Phase::Compensating {
            self.listen(k, alarm);
        } else {
            self.recent.fill(0);
            self.next = 0;
            self.normal_in_a_row = 0;
            if !self.debouncing.latch {
                self.raised = 0;
            }
        }
        self.raised.checked_sub(1)
    }

    /// Sample of the oldest alarm that may yet lead to a fault, at sample `k`.
    pub(super) fn pending(&self, k: u64) -> Option<u64> {
        let window = self.debouncing.out_of;
        (0..window).rev().find_map(|age| {
            let slot = (self.next + 2 * window - 1 - age) % window;
            (self.recent[as_index(slot)] != 0).then(|| k.saturating_sub(age))
        })
    }

    fn listen(&mut self, k: u64, alarm: bool) {
        self.recent[as_index(self.next)] = u64::from(alarm);
        self.next = (self.next + 1) % self.debouncing.out_of;
        self.normal_in_a_row = if alarm { 0 } else { self.normal_in_a_row + 1 };
        if self.raised > 0 {
            if !self.debouncing.latch && self.normal_in_a_row >= self.debouncing.clear {
                self.raised = 0;
                self.recent.fill(0);
            }
        } else if self.recent.iter().sum::<u64>() >= self.debouncing.raise {
            self.raised = self.pending(k).unwrap_or(k) + 1;
        }
    }
}

/// The ring is a `Vec`, so its length and every index into it fit.
fn as_index(slot: u64) -> usize {
    usize::try_from(slot).unwrap_or(0)
}

impl<T: Scalar> Stage<T> for Debounce {
    fn reset(&mut self) {
        self.recent.fill(0);
        self.next = 0;
        self.normal_in_a_row = 0;
        self.raised = 0;
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.counts("debounce recent alarms", &mut self.recent);
        let mut counts = [self.next, self.normal_in_a_row, self.raised];
        visitor.counts("debounce next, normal, raised", &mut counts);
        // A foreign snapshot must not point beyond the ring.
        self.next = counts[0] % self.debouncing.out_of;
        [_, self.normal_in_a_row, self.raised] = counts;
    }
}

impl<T: Scalar> DecisionRule<T> for Debounce {
    fn residual_len(&self) -> usize {
        self.residual_len
    }

    fn decide(&mut self, evidence: Evidence<'_, T>) -> Decision<T> {
        match self.judge(evidence.k, evidence.phase, evidence.verdict.alarm()) {
            Some(since) => Decision::Fault(Fault::since(since)),
            None => Decision::Nominal,
        }
    }
}
