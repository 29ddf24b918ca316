//! What happened, and at which sample: phases and alarms are events, not booleans.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Something that happened at a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Event {
    /// Sample index.
    pub k: u64,
    /// What happened.
    pub kind: EventKind,
}

/// Kinds of events.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum EventKind {
    /// The compensator began to learn the bias.
    TrainingStarted,
    /// The parameters converged and were frozen: the switch is open.
    Frozen,
    /// The training reached its longest duration before the parameters converged.
    TrainingInconclusive,
    /// The bias model does not reproduce the bias in simulation, or diverged.
    BiasModelRejected,
    /// The residual jumped while the compensator was still learning.
    HardFaultWhileTraining,
    /// The input left the range that the bias was learned in.
    OperatingPointLeft,
    /// The input is back in the range that the bias was learned in.
    OperatingPointRegained,
    /// The inputs went beyond anything that the threshold was set on: it states no rate of false alarms.
    ThresholdVoid,
    /// The inputs are back where the threshold was set: it states its rate again.
    ThresholdValid,
    /// The plant itself has changed: what is left of the residual follows the inputs.
    CharacteristicsChanged,
    /// Training would start again if nobody had to be asked.
    RetrainingWanted,
    /// What training was to start again for is over.
    RetrainingWithdrawn,
    /// A safeguard of the identifier acted for the first time since the last reset.
    WindUpGuard,
    /// The decision rule raised an alarm.
    AlarmRaised,
    /// The decision rule cleared its alarm.
    AlarmCleared,
    /// A missing sample was replaced by the last good one.
    SampleHeld,
}

impl fmt::Display for EventKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::TrainingStarted => "training started",
            Self::Frozen => "parameters converged and frozen",
            Self::TrainingInconclusive => "training ended without convergence",
            Self::BiasModelRejected => "bias model rejected",
            Self::HardFaultWhileTraining => "hard fault while training",
            Self::OperatingPointLeft => "operating point left the trained range",
            Self::OperatingPointRegained => "operating point back in the trained range",
            Self::ThresholdVoid => "inputs beyond what the threshold was set on: it states no rate",
            Self::ThresholdValid => "inputs back where the threshold was set: it states its rate",
            Self::CharacteristicsChanged => "characteristics of the plant changed",
            Self::RetrainingWanted => "training again is wanted",
            Self::RetrainingWithdrawn => "training again is not wanted any more",
            Self::WindUpGuard => "wind-up guard acted",
            Self::AlarmRaised => "alarm raised",
            Self::AlarmCleared => "alarm cleared",
            Self::SampleHeld => "missing sample held",
        })
    }
}

/// The few events that one sample can cause, without allocation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Events {
    kinds: [Option<EventKind>; Self::CAPACITY],
}

impl Events {
    /// Most events that one sample can cause.
    pub const CAPACITY: usize = 6;

    /// No events.
    ///
    /// ```
    /// # use fd_core::Events;
    /// assert_eq!(Events::none().iter().count(), 0);
    /// ```
    #[must_use]
    pub const fn none() -> Self {
        Self { kinds: [None; Self::CAPACITY] }
    }

    /// Adds an event; beyond [`Events::CAPACITY`] the newest replaces the last.
    pub fn push(&mut self, kind: EventKind) {
        let free = self.kinds.iter().position(Option::is_none).unwrap_or(Self::CAPACITY - 1);
        self.kinds[free] = Some(kind);
    }

    /// The events in the order in which they occurred.
    pub fn iter(&self) -> impl Iterator<Item = EventKind> + '_ {
        self.kinds.iter().copied().flatten()
    }
}
