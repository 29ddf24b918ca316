//! Locks that a panic elsewhere does not close: what they hold is whole between any two calls.

use std::sync::{Mutex, MutexGuard, PoisonError};

pub(super) fn open<T>(lock: &Mutex<T>) -> MutexGuard<'_, T> {
    lock.lock().unwrap_or_else(PoisonError::into_inner)
}
