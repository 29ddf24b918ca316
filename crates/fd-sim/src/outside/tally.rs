//! Counts of the requests to a simulator, and of failures.

use std::{
    sync::{
        Mutex,
        atomic::{AtomicU64, Ordering::Relaxed},
    },
    time::Duration,
};

use super::{error::OutsideError, lock::open};

/// Counts of what was asked of a simulator, for all its copies together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Runs that were asked for.
    pub asked: u64,
    /// Runs that were made; the others were known from before.
    pub made: u64,
    /// Runs that were made again up to where they were, for a copy, after a death or for want of workers.
    pub repeated: u64,
    /// Steps that were made, those of repeated runs among them.
    pub steps: u64,
    /// Simulators that were started.
    pub started: u64,
    /// Simulators that ended by themselves or had to be ended.
    pub deaths: u64,
    /// Runs that were lost, because simulators kept ending or broke the contract.
    pub lost: u64,
    /// Time inside of simulators, summed over them.
    pub inside: Duration,
}

/// The counters, shared.
#[derive(Debug, Default)]
pub(super) struct Tally {
    pub asked: AtomicU64,
    pub made: AtomicU64,
    pub repeated: AtomicU64,
    pub steps: AtomicU64,
    pub started: AtomicU64,
    pub deaths: AtomicU64,
    pub lost: AtomicU64,
    nanoseconds: AtomicU64,
    last: Mutex<Option<OutsideError>>,
}

impl Tally {
    pub(super) fn add(counter: &AtomicU64, n: u64) {
        counter.fetch_add(n, Relaxed);
    }

    pub(super) fn inside(&self, time: Duration) {
        let nanoseconds = u64::try_from(time.as_nanos()).unwrap_or(u64::MAX);
        Self::add(&self.nanoseconds, nanoseconds);
    }

    /// Keeps what went wrong last.
    pub(super) fn note(&self, trouble: OutsideError) {
        *open(&self.last) = Some(trouble);
    }

    pub(super) fn trouble(&self) -> Option<OutsideError> {
        open(&self.last).clone()
    }

    pub(super) fn counts(&self) -> Counts {
        let [asked, made, repeated, steps, started, deaths, lost, nanoseconds] = [
            &self.asked,
            &self.made,
            &self.repeated,
            &self.steps,
            &self.started,
            &self.deaths,
            &self.lost,
            &self.nanoseconds,
        ]
        .map(|counter| counter.load(Relaxed));
        let inside = Duration::from_nanos(nanoseconds);
        Counts { asked, made, repeated, steps, started, deaths, lost, inside }
    }
}
