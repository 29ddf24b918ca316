//! What goes wrong in a user's code, and whether that is the end.

use std::sync::{
    Mutex, MutexGuard, PoisonError,
    atomic::{AtomicBool, Ordering::Relaxed},
};

use pyo3::{exceptions::PyArithmeticError, prelude::*};

/// What went wrong in a user's code, and whether that is the end.
#[derive(Debug, Default)]
pub(crate) struct Troubles {
    stopped: AtomicBool,
    raised: Mutex<Option<(String, PyErr)>>,
    note: Mutex<Option<String>>,
}

fn open<T>(lock: &Mutex<T>) -> MutexGuard<'_, T> {
    lock.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Troubles {
    /// Ends all work at the next call.
    pub(crate) fn stop(&self) {
        self.stopped.store(true, Relaxed);
    }

    pub(crate) fn is_stopped(&self) -> bool {
        self.stopped.load(Relaxed)
    }

    /// An exception that is the end; the first one counts.
    pub(crate) fn raise(&self, what: String, error: PyErr) {
        open(&self.raised).get_or_insert((what, error));
        self.stop();
    }

    /// The exception that was the end, and what was asked.
    pub(crate) fn take(&self) -> Option<(String, PyErr)> {
        open(&self.raised).take()
    }

    /// Something that may be why a study fails; the first one counts.
    pub(crate) fn note(&self, text: impl FnOnce() -> String) {
        open(&self.note).get_or_insert_with(text);
    }

    /// The first thing that may be why.
    pub(crate) fn noted(&self) -> Option<String> {
        open(&self.note).clone()
    }
}

/// Whether an exception means that there are no numbers here: an `ArithmeticError`, `fdiag.Diverged` among them.
pub(crate) fn is_divergence(py: Python<'_>, error: &PyErr) -> bool {
    error.is_instance_of::<PyArithmeticError>(py)
}
