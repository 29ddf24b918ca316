//! What speaks against the healthy logs, and where the thresholds that came from them are void, in words.

use std::path::Path;

use fd_core::EventKind;
use fdiag::training::{Doubt, Names, Trace};
use serde::{Deserialize, Serialize};

/// A doubt about a healthy log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LogDoubt {
    /// The log; none when it is about all of them together.
    pub log: Option<String>,
    /// What it is.
    pub doubt: Doubt,
    /// The same in words.
    pub words: String,
}

impl LogDoubt {
    pub(super) fn new(log: Option<&Path>, doubt: Doubt, names: &Names<'_>) -> Self {
        let name = |path: &Path| path.file_name().map(|name| name.to_string_lossy().into_owned());
        let words = doubt.in_words(names);
        Self { log: log.and_then(name), doubt, words }
    }

    /// The log and what is said of it.
    pub(super) fn sentence(&self) -> String {
        match &self.log {
            Some(log) => format!("{log}: {}.", self.words),
            None => format!("The healthy logs together: {}.", self.words),
        }
    }
}

/// Samples of a log for which the threshold states no rate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Void {
    /// Time in s of the first one.
    pub since_s: f64,
    /// Share of the samples.
    pub share: f64,
    /// Whether the first alarm is among them.
    pub first_alarm: bool,
    /// Why.
    pub reason: VoidReason,
}

/// Why a threshold states no rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum VoidReason {
    /// The inputs left the range of the healthy logs.
    OperatingPoint,
    /// The inputs moved in a way that the threshold was not set on: a larger jump, a faster motion, another level.
    InputMotion,
    /// The plant was found to have changed.
    PlantChanged,
}

impl Void {
    /// From the events of a log. Thresholds are void while the inputs are outside the range that was learned or
    /// move as they did not then,
    /// and for good once the bias was learned again elsewhere or the plant has changed: they were set on what
    /// the old bias left.
    pub(super) fn of(trace: &Trace) -> Option<Self> {
        let (mut is_outside, mut is_beyond, mut has_changed) = (false, false, false);
        let mut reason = None;
        let mut void = vec![false; trace.len()];
        let mut events = trace.events.iter().peekable();
        for (k, void) in void.iter_mut().enumerate() {
            if trace.restarts.contains(&k) {
                (is_outside, is_beyond, has_changed) = (false, false, false);
            }
            while let Some(event) = events.next_if(|event| event.k <= k as u64) {
                let (flag, is_void, why) = match event.kind {
                    EventKind::OperatingPointLeft => {
                        (&mut is_outside, true, VoidReason::OperatingPoint)
                    }
                    EventKind::OperatingPointRegained => {
                        (&mut is_outside, false, VoidReason::OperatingPoint)
                    }
                    EventKind::ThresholdVoid => (&mut is_beyond, true, VoidReason::InputMotion),
                    EventKind::ThresholdValid => (&mut is_beyond, false, VoidReason::InputMotion),
                    EventKind::CharacteristicsChanged => {
                        (&mut has_changed, true, VoidReason::PlantChanged)
                    }
                    _ => continue,
                };
                *flag = is_void;
                if is_void {
                    reason = reason.or(Some(why));
                }
            }
            *void = is_outside || is_beyond || has_changed;
        }
        let first = void.iter().position(|void| *void)?;
        let count = void.iter().filter(|void| **void).count();
        Some(Self {
            since_s: trace.time[first],
            share: count as f64 / trace.len() as f64,
            first_alarm: trace.first_alarm(0).is_some_and(|k| void[k]),
            reason: reason?,
        })
    }

    /// What is void and why, as a sentence without its full stop.
    pub(super) fn in_words(&self) -> String {
        let why = match self.reason {
            VoidReason::OperatingPoint => "the inputs leave the range of the healthy logs",
            VoidReason::InputMotion => "the inputs move as in no healthy log",
            VoidReason::PlantChanged => "the plant has changed since the healthy logs",
        };
        let alarm = if self.first_alarm { ", the first alarm among them" } else { "" };
        format!(
            "from {:.1} s on {why}: the threshold states no rate of false alarms for {:.0} % of the \
             samples{alarm}",
            self.since_s,
            100.0 * self.share
        )
    }
}
