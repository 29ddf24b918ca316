//! In unit tests each of these is the standard library's, or loom's inside [`in_model`]: one build serves all tests. Time is no
//! part of a model: whether a simulator was idle for long is the same throughout.

use std::{
    cell::Cell,
    ops::{Deref, DerefMut},
    sync::{self, LockResult, PoisonError, TryLockError, TryLockResult, atomic::Ordering},
    thread, time,
};

use super::Rung;

std::thread_local! {
    /// Whether every simulator counts as idle, inside a model. The threads of a model are one.
    static MODEL: Cell<Option<bool>> = const { Cell::new(None) };
}

/// Runs a model inside of loom, in which every simulator counts as idle or none.
pub(in crate::outside) fn in_model(is_late: bool, model: impl FnOnce()) {
    struct Leave;
    impl Drop for Leave {
        fn drop(&mut self) {
            MODEL.set(None);
        }
    }
    let _leave = Leave;
    MODEL.set(Some(is_late));
    model();
}

fn is_modelled() -> bool {
    MODEL.get().is_some()
}

#[derive(Debug)]
pub(in crate::outside) enum Mutex<T> {
    Real(sync::Mutex<T>),
    Modelled(loom::sync::Mutex<T>),
}

#[derive(Debug)]
pub(in crate::outside) enum MutexGuard<'a, T> {
    Real(sync::MutexGuard<'a, T>),
    Modelled(loom::sync::MutexGuard<'a, T>),
}

impl<T> Mutex<T> {
    pub(in crate::outside) fn new(value: T) -> Self {
        if is_modelled() {
            Self::Modelled(loom::sync::Mutex::new(value))
        } else {
            Self::Real(sync::Mutex::new(value))
        }
    }

    fn lock(&self) -> LockResult<MutexGuard<'_, T>> {
        fn held<G, H>(lock: LockResult<G>, hold: impl Fn(G) -> H) -> LockResult<H> {
            match lock {
                Ok(guard) => Ok(hold(guard)),
                Err(poisoned) => Err(PoisonError::new(hold(poisoned.into_inner()))),
            }
        }
        match self {
            Self::Real(mutex) => held(mutex.lock(), MutexGuard::Real),
            Self::Modelled(mutex) => held(mutex.lock(), MutexGuard::Modelled),
        }
    }

    pub(in crate::outside) fn try_lock(&self) -> TryLockResult<MutexGuard<'_, T>> {
        fn held<G, H>(lock: TryLockResult<G>, hold: impl Fn(G) -> H) -> TryLockResult<H> {
            match lock {
                Ok(guard) => Ok(hold(guard)),
                Err(TryLockError::WouldBlock) => Err(TryLockError::WouldBlock),
                Err(TryLockError::Poisoned(poisoned)) => {
                    Err(TryLockError::Poisoned(PoisonError::new(hold(poisoned.into_inner()))))
                }
            }
        }
        match self {
            Self::Real(mutex) => held(mutex.try_lock(), MutexGuard::Real),
            Self::Modelled(mutex) => held(mutex.try_lock(), MutexGuard::Modelled),
        }
    }
}

impl<T> Deref for MutexGuard<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        match self {
            Self::Real(guard) => guard,
            Self::Modelled(guard) => guard,
        }
    }
}

impl<T> DerefMut for MutexGuard<'_, T> {
    fn deref_mut(&mut self) -> &mut T {
        match self {
            Self::Real(guard) => guard,
            Self::Modelled(guard) => guard,
        }
    }
}

pub(in crate::outside) fn open<T>(lock: &Mutex<T>) -> MutexGuard<'_, T> {
    lock.lock().unwrap_or_else(PoisonError::into_inner)
}

#[derive(Debug)]
pub(in crate::outside) enum AtomicU64 {
    Real(sync::atomic::AtomicU64),
    Modelled(loom::sync::atomic::AtomicU64),
}

impl AtomicU64 {
    pub(in crate::outside) fn new(value: u64) -> Self {
        if is_modelled() {
            Self::Modelled(loom::sync::atomic::AtomicU64::new(value))
        } else {
            Self::Real(sync::atomic::AtomicU64::new(value))
        }
    }

    pub(in crate::outside) fn load(&self, order: Ordering) -> u64 {
        match self {
            Self::Real(number) => number.load(order),
            Self::Modelled(number) => number.load(order),
        }
    }

    pub(in crate::outside) fn store(&self, value: u64, order: Ordering) {
        match self {
            Self::Real(number) => number.store(value, order),
            Self::Modelled(number) => number.store(value, order),
        }
    }

    pub(in crate::outside) fn fetch_add(&self, value: u64, order: Ordering) -> u64 {
        match self {
            Self::Real(number) => number.fetch_add(value, order),
            Self::Modelled(number) => number.fetch_add(value, order),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::outside) enum ThreadId {
    Real(thread::ThreadId),
    Modelled(loom::thread::ThreadId),
}

pub(in crate::outside) struct Thread(ThreadId);

impl Thread {
    pub(in crate::outside) fn id(&self) -> ThreadId {
        self.0
    }
}

pub(in crate::outside) fn current() -> Thread {
    Thread(if is_modelled() {
        ThreadId::Modelled(loom::thread::current().id())
    } else {
        ThreadId::Real(thread::current().id())
    })
}

#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub(in crate::outside) enum Instant {
    Real(time::Instant),
    Modelled,
}

impl Instant {
    pub(in crate::outside) fn now() -> Self {
        if is_modelled() { Self::Modelled } else { Self::Real(time::Instant::now()) }
    }

    pub(in crate::outside) fn elapsed(self) -> time::Duration {
        match self {
            Self::Real(since) => since.elapsed(),
            Self::Modelled if MODEL.get() == Some(true) => time::Duration::MAX,
            Self::Modelled => time::Duration::ZERO,
        }
    }
}

#[derive(Debug, Default)]
pub(in crate::outside) struct Bell(Rung);

impl Bell {
    pub(in crate::outside) fn ring(&self) {
        if !is_modelled() {
            self.0.ring();
        }
    }

    /// Never heard in a model: whoever waits lets the others go on, and looks again.
    pub(in crate::outside) fn wait(&self) {
        if is_modelled() {
            loom::thread::yield_now();
        } else {
            self.0.wait();
        }
    }
}
