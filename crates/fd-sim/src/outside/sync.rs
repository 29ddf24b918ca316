//! What threads meet at in the [pool](super::pool): that of the standard library; in unit tests it is chosen between that and
//! loom's, which goes through all orders in which threads can meet.

use std::{sync::Condvar, time::Duration};
#[cfg(not(test))]
pub(super) use std::{
    sync::{Mutex, MutexGuard, atomic::AtomicU64},
    thread::{ThreadId, current},
    time::Instant,
};

#[cfg(not(test))]
pub(super) use self::Rung as Bell;
use super::lock;
#[cfg(not(test))]
pub(super) use super::lock::open;
#[cfg(test)]
pub(super) use modelled::{
    AtomicU64, Bell, Instant, Mutex, MutexGuard, ThreadId, current, in_model, open,
};

#[cfg(test)]
mod modelled;

/// How long it is waited before looking again.
const LOOK: Duration = Duration::from_millis(2);

/// Rung when something has changed. Who does not hear it looks again soon.
#[derive(Debug, Default)]
pub(super) struct Rung(std::sync::Mutex<()>, Condvar);

impl Rung {
    pub(super) fn ring(&self) {
        self.1.notify_one();
    }

    pub(super) fn wait(&self) {
        // Rung or not, it is looked again.
        drop(self.1.wait_timeout(lock::open(&self.0), LOOK));
    }
}
