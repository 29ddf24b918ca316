//! The monitor watches itself: how far behind it is, how old its last sample, how large it has become.

use std::{
    sync::Arc,
    time::{Duration, Instant},
};

use fd_watch::{Answer, Board, Doing, Health, Message, Monitor};

use super::super::say::{is_watched, remark};

/// How often somebody who looks is shown something new.
const LOOK: Duration = Duration::from_secs(1);
/// How often a terminal is told how it goes.
const WORD: Duration = Duration::from_secs(10);

/// What the monitor knows of itself.
pub(super) struct Pulse {
    begun: Instant,
    looked: Option<Instant>,
    told: Instant,
    lag: Duration,
    last_sample: Option<Instant>,
    lines: u64,
    unheard: Option<u64>,
    board: Option<Arc<Board>>,
    has_terminal: bool,
}

impl Pulse {
    pub(super) fn new(board: Option<Arc<Board>>) -> Self {
        let now = Instant::now();
        let has_terminal = is_watched();
        let (looked, last_sample) = (None, None);
        Self {
            begun: now,
            looked,
            told: now,
            lag: Duration::ZERO,
            last_sample,
            lines: 0,
            unheard: None,
            board,
            has_terminal,
        }
    }

    /// Lines that were read then have now been judged, with so many samples in them.
    pub(super) fn beat(&mut self, read: Instant, lines: u64, samples: u64) {
        self.lag = read.elapsed();
        self.lines += lines;
        if 0 < samples {
            self.last_sample = Some(read);
        }
    }

    pub(super) fn say(&self, messages: &[Message]) {
        if let Some(board) = &self.board {
            board.say(messages);
        }
    }

    /// Bytes of the journal that a broker has not confirmed.
    #[cfg(feature = "mqtt")]
    pub(super) fn hears(&mut self, unheard: Option<u64>) {
        self.unheard = unheard;
    }

    /// What was answered on the page.
    pub(super) fn take_answers(&self) -> Vec<Answer> {
        self.board.as_ref().map_or_else(Vec::new, |board| board.take_answers())
    }

    /// Shows how it goes, when it is time for it.
    pub(super) fn look(&mut self, monitor: &Monitor, cannot_save: bool) {
        let is_due = self.looked.is_none_or(|looked| LOOK <= looked.elapsed());
        if !is_due || (self.board.is_none() && !self.has_terminal) {
            return;
        }
        self.looked = Some(Instant::now());
        let health = self.health(monitor, cannot_save);
        if let Some(board) = &self.board {
            board.set_health(health);
            board.look_at(monitor);
        }
        if self.has_terminal && WORD <= self.told.elapsed() {
            self.told = Instant::now();
            let age =
                health.age_s.map_or_else(|| "never".to_owned(), |age| format!("{age:.1} s ago"));
            let Health { samples, alarms, lag_s, units, .. } = health;
            remark(&format!(
                "{samples} samples of {} units, the last {age}, {alarms} alarms, {:.0} ms behind",
                units.iter().sum::<u64>(),
                1e3 * lag_s
            ));
        }
    }

    fn health(&self, monitor: &Monitor, cannot_save: bool) -> Health {
        let counts = monitor.counts();
        let mut units = [0; 4];
        for unit in monitor.units() {
            units[match unit.doing {
                Doing::Learning { .. } => 0,
                Doing::Settling => 1,
                Doing::Watched => 2,
                Doing::Alarmed => 3,
            }] += 1;
        }
        Health {
            samples: counts.rows,
            refused: counts.refused,
            dropped: counts.dropped,
            lines: self.lines,
            alarms: counts.alarms,
            events: counts.events,
            units,
            unheard: self.unheard,
            unsaved: monitor.to_save() as u64,
            cannot_save,
            lag_s: self.lag.as_secs_f64(),
            age_s: self.last_sample.map(|last| last.elapsed().as_secs_f64()),
            up_s: self.begun.elapsed().as_secs_f64(),
            memory: memory(),
        }
    }
}

/// Resident bytes, where there is `/proc`.
fn memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kilobytes * 1024)
}
