//! A few running simulators, lent to many copies of one.

use std::{
    sync::{
        TryLockError,
        atomic::Ordering::{Acquire, Relaxed, Release},
    },
    time::Duration,
};

use super::{
    source::Instance,
    sync::{AtomicU64, Bell, Instant, Mutex, MutexGuard, ThreadId, current, open},
};

/// A simulator that was not asked for so long may be taken from who has it: whoever steps asks every few
/// microseconds, and a run that is over is often just left. Who is robbed repeats its run, so this is a matter
/// of time, not of results.
const IDLE: Duration = Duration::from_millis(20);

/// A few running simulators.
#[derive(Debug)]
pub(super) struct Pool {
    slots: Vec<Room>,
    /// Numbers of leases, from 1.
    leases: AtomicU64,
    /// Rung when one is given back.
    bell: Bell,
}

/// Room for one simulator.
#[derive(Debug)]
struct Room {
    /// The lease that has it; 0 for none. It changes under the lock, and can be seen without.
    holder: AtomicU64,
    slot: Mutex<Slot>,
}

/// What is in a room.
#[derive(Debug)]
pub(super) struct Slot {
    pub instance: Option<Box<dyn Instance>>,
    thread: ThreadId,
    used: Instant,
}

/// The right to a simulator, unless somebody has taken it since.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lease {
    slot: usize,
    number: u64,
}

impl Pool {
    pub(super) fn new(workers: usize) -> Self {
        let thread = current().id();
        let room = || Room {
            holder: AtomicU64::new(0),
            slot: Mutex::new(Slot { instance: None, thread, used: Instant::now() }),
        };
        Self {
            slots: (0..workers.max(1)).map(|_| room()).collect(),
            leases: AtomicU64::new(0),
            bell: Bell::default(),
        }
    }

    /// Puts a simulator into the first room.
    pub(super) fn fill(&self, instance: Box<dyn Instance>) {
        open(&self.slots[0].slot).instance = Some(instance);
    }

    /// The simulator in the first room, if it is there and nobody has it.
    pub(super) fn empty(&self) -> Option<Box<dyn Instance>> {
        let room = self.slots.first()?;
        let mut slot = open(&room.slot);
        if room.holder.load(Acquire) == 0 { slot.instance.take() } else { None }
    }

    /// How many simulators there may be.
    pub(super) fn workers(&self) -> usize {
        self.slots.len()
    }

    /// The simulator of a lease; `None` when somebody else has it by now.
    pub(super) fn slot(&self, lease: Lease) -> Option<MutexGuard<'_, Slot>> {
        let room = &self.slots[lease.slot];
        // Who has taken it may be at work for long.
        let is_mine = || room.holder.load(Acquire) == lease.number;
        if !is_mine() {
            return None;
        }
        let mut slot = open(&room.slot);
        is_mine().then(|| {
            (slot.thread, slot.used) = (current().id(), Instant::now());
            slot
        })
    }

    /// A simulator: one that nobody has; else one that this thread has left, or that was left long ago. Waits
    /// until there is one: every call has its limit, so there will be.
    pub(super) fn lease(&self) -> Lease {
        let number = self.leases.fetch_add(1, Relaxed) + 1;
        loop {
            if let Some(slot) = self.take(number) {
                return Lease { slot, number };
            }
            self.bell.wait();
        }
    }

    fn take(&self, number: u64) -> Option<usize> {
        let me = current().id();
        let mut best: Option<(u8, Instant, usize, MutexGuard<'_, Slot>)> = None;
        for (i, room) in self.slots.iter().enumerate() {
            let slot = match room.slot.try_lock() {
                Ok(slot) => slot,
                Err(TryLockError::Poisoned(slot)) => slot.into_inner(),
                // At work.
                Err(TryLockError::WouldBlock) => continue,
            };
            let rank = match room.holder.load(Acquire) {
                0 if slot.instance.is_some() => 0,
                0 => 1,
                _ if slot.thread == me => 2,
                _ if IDLE <= slot.used.elapsed() => 3,
                _ => continue,
            };
            let used = slot.used;
            if best.as_ref().is_none_or(|(r, u, ..)| (rank, used) < (*r, *u)) {
                best = Some((rank, used, i, slot));
            }
        }
        let (_, _, i, mut slot) = best?;
        (slot.thread, slot.used) = (me, Instant::now());
        self.slots[i].holder.store(number, Release);
        Some(i)
    }

    /// Gives a simulator back.
    pub(super) fn give_back(&self, lease: Lease) {
        if let Some(slot) = self.slot(lease) {
            self.slots[lease.slot].holder.store(0, Release);
            drop(slot);
            self.bell.ring();
        }
    }
}

#[cfg(test)]
mod tests;
