//! The memory of a unit, as it is kept in a file, and back.

use fd_core::{Snapshot, SnapshotError};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::{
    alarms::Annunciator,
    bits,
    clock::Clock,
    plan::{Plan, PlanError},
    unit::{Phase, Unit},
};

/// Everything of a unit that its future depends on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UnitMemory {
    unit: String,
    clock: Clock,
    phase: PhaseMemory,
    alarm: Annunciator,
    wish: Option<String>,
    time: Option<u64>,
    refused: u64,
}

/// What a unit has learned from; written once, beside its memory.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LearnedRows {
    #[serde(with = "bits::many")]
    rows: Vec<f64>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
enum PhaseMemory {
    Learning(LearnedRows),
    Watching { pipeline: Snapshot, own: bool },
}

/// A memory does not belong to this monitor, or is damaged.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum MemoryError {
    /// The snapshot of the pipeline.
    #[error(transparent)]
    Snapshot(#[from] SnapshotError),
    /// The pipeline cannot be made.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// Numbers that cannot be.
    #[error("{what}: expected {expected}")]
    Number {
        /// Which.
        what: &'static str,
        /// What they could be.
        expected: &'static str,
    },
    /// What the unit learned from is not there.
    #[error("the samples that it learned from are missing")]
    NothingLearned,
}

impl UnitMemory {
    /// The unit.
    #[must_use]
    pub fn unit(&self) -> &str {
        &self.unit
    }

    /// Time in s of the last sample that it has judged or learned from.
    #[must_use]
    pub fn time(&self) -> Option<f64> {
        self.time.map(f64::from_bits)
    }

    /// Whether what the unit learned from is needed as well.
    #[must_use]
    pub fn needs_learned(&self) -> bool {
        matches!(self.phase, PhaseMemory::Watching { own: true, .. })
    }

    pub(crate) fn of(unit: &mut Unit) -> Self {
        Self {
            unit: unit.name.clone(),
            clock: unit.clock.clone(),
            phase: match &mut unit.phase {
                Phase::Learning { rows } => {
                    PhaseMemory::Learning(LearnedRows { rows: rows.clone() })
                }
                Phase::Watching(pipeline) => PhaseMemory::Watching {
                    pipeline: Snapshot::of(pipeline.as_mut()),
                    own: unit.is_own,
                },
            },
            alarm: unit.alarm.clone(),
            wish: unit.wish.clone(),
            time: unit.time.map(f64::to_bits),
            refused: unit.refused.count,
        }
    }

    pub(crate) fn restored(
        self,
        plan: &Plan,
        learned: Option<LearnedRows>,
    ) -> Result<Unit, MemoryError> {
        let mut unit = Unit::new(plan, &self.unit)?;
        let number = |what, expected| Err(MemoryError::Number { what, expected });
        if !self.clock.is_sound(plan.channels()) {
            return number("the clock", "finite times and a value per channel");
        }
        if self.time().is_some_and(|time| !time.is_finite()) {
            return number("the time of the last sample", "a finite number");
        }
        if !self.alarm.is_sound() {
            return number("the alarm", "finite times, and a name if it stands");
        }
        match self.phase {
            PhaseMemory::Learning(LearnedRows { rows }) => {
                let most = usize::try_from(plan.to_learn).unwrap_or(usize::MAX);
                let is_whole = rows.len().is_multiple_of(plan.channels().max(1));
                if plan.to_learn == 0 || !is_whole || most <= rows.len() / plan.channels().max(1) {
                    return number(
                        "the samples to learn from",
                        "whole samples that are not yet enough",
                    );
                }
                unit.phase = Phase::Learning { rows };
            }
            PhaseMemory::Watching { pipeline, own } => {
                if own != (0 < plan.to_learn) {
                    return number("where it learned", "what the plan says");
                }
                let mut running = match plan.common().map_err(PlanError::from)? {
                    Some(running) => running,
                    None => plan.own(&learned.ok_or(MemoryError::NothingLearned)?.rows)?,
                };
                pipeline.restore(&mut running)?;
                unit.phase = Phase::Watching(Box::new(running));
            }
        }
        unit.time = self.time.map(f64::from_bits);
        unit.clock = self.clock;
        unit.clock.resume();
        unit.alarm = self.alarm;
        unit.wish = self.wish;
        unit.refused.count = self.refused;
        Ok(unit)
    }
}

impl LearnedRows {
    pub(crate) fn new(rows: Vec<f64>) -> Self {
        Self { rows }
    }

    pub(crate) fn into_rows(self) -> Vec<f64> {
        self.rows
    }
}
