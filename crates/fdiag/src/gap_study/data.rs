//! Logs, divided into what is fitted and what is held out.

use fd_gap::fit::Log;
use fd_model::{Record, SampleTime};
use fd_sim::simulate::{Follower, Simulator};

use super::{
    error::GapError,
    log_finding::LogFinding,
    log_part::{LogPart, Pace, Role},
};

/// All logs of a diagnosis.
#[derive(Clone, Debug)]
pub(super) struct Data {
    /// What models are fitted to.
    pub fit: Vec<Record>,
    /// What no fit sees.
    pub held_out: Vec<Record>,
    /// Where each part comes from, fitted ones first.
    pub parts: Vec<LogPart>,
    /// Where the time between samples comes from.
    pub pace: Pace,
    /// What was found while reading.
    pub findings: Vec<LogFinding>,
    /// All of it, where only stretches are fitted.
    pub long: Option<Long>,
}

/// The parts of long logs that no fit can take whole.
#[derive(Clone, Debug)]
pub(super) struct Long {
    /// Whole parts, fitted ones first, with where they come from.
    pub parts: Vec<(LogPart, Record)>,
    /// Length of a stretch.
    pub length: usize,
}

impl Data {
    /// Puts the logged outputs among the inputs, for a simulator that follows them.
    pub(super) fn follow(&mut self, follower: &Follower<'_>) {
        for record in self.fit.iter_mut().chain(&mut self.held_out) {
            // A record of this model can be followed.
            if let Ok(followed) = follower.record(record) {
                *record = followed;
            }
        }
    }

    /// Time between samples.
    pub(super) fn ts(&self) -> Option<SampleTime> {
        self.fit.first().map(Record::ts)
    }

    /// Whether every held-out record is on the clock of a fitted one.
    pub(super) fn is_on_one_clock(&self) -> bool {
        let is_later = |record: &Record| self.fit.iter().any(|fit| record.comes_after(fit));
        self.held_out.iter().all(is_later)
    }

    /// The logs in the order and the units of a simulator, fitted ones and held-out ones.
    pub(super) fn logs(&self, simulator: &dyn Simulator) -> Result<[Vec<Log>; 2], GapError> {
        let all = self.fit.iter().chain(&self.held_out).zip(&self.parts).enumerate();
        let mut logs = [Vec::new(), Vec::new()];
        for (i, (record, part)) in all {
            let log = Log::new(record, simulator, i + 1).map_err(|source| GapError::Unfit {
                file: part.path.clone(),
                source: Box::new(source),
            })?;
            let earlier = if part.role == Role::HeldOut { &self.fit[..] } else { &[] };
            logs[usize::from(part.role == Role::HeldOut)]
                .push(log.continuing(record, earlier, simulator)?);
        }
        Ok(logs)
    }

    /// A stretch of a part of a file; parts are in the order of the records, fitted ones first.
    pub(super) fn add(&mut self, part: &LogPart, record: &Record, [from, to]: [usize; 2]) {
        let first = part.samples[0];
        let samples = [first + from, first + to];
        let record = record.slice(from, to);
        let new = LogPart::new(&part.path, part.role, samples, &record, &part.time_base);
        match part.role {
            Role::Fit => {
                self.parts.insert(self.fit.len(), new);
                self.fit.push(record);
            }
            Role::HeldOut => {
                self.parts.push(new);
                self.held_out.push(record);
            }
        }
    }
}
