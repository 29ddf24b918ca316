//! Whether what a file says may be executed: programs started, shared libraries loaded.

use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};

use super::error::OutsideError;

/// How many have forbidden it.
static FORBIDDEN: AtomicUsize = AtomicUsize::new(0);

/// From now on nothing in this process starts a program or loads a library that a model file names (`kind = "process"`,
/// `kind = "fmu"`): it ends in [`OutsideError::Forbidden`] instead. There is no way back.
///
/// Simulators that are objects of the host language, and programs that were started before, are not concerned.
pub fn forbid_programs() {
    FORBIDDEN.fetch_add(1, SeqCst);
}

/// The same for as long as the value lives.
///
/// ```
/// use fd_sim::outside::{NoPrograms, OutsideError, Process};
///
/// let guard = NoPrograms::begin();
/// let refused = Process::new(["true"]).contract();
/// assert!(matches!(refused, Err(OutsideError::Forbidden { .. })));
/// drop(guard);
/// ```
#[derive(Debug)]
#[must_use = "programs are allowed again when this is dropped"]
pub struct NoPrograms(());

impl NoPrograms {
    /// Forbids programs.
    pub fn begin() -> Self {
        forbid_programs();
        Self(())
    }
}

impl Drop for NoPrograms {
    fn drop(&mut self) {
        FORBIDDEN.fetch_sub(1, SeqCst);
    }
}

/// Whether programs are forbidden.
#[must_use]
pub fn programs_are_forbidden() -> bool {
    FORBIDDEN.load(SeqCst) != 0
}

/// Asked before anything is started or loaded, however it came to it.
pub(super) fn check(place: &str, what: impl FnOnce() -> String) -> Result<(), OutsideError> {
    if programs_are_forbidden() {
        return Err(OutsideError::Forbidden { place: place.to_owned(), what: what() });
    }
    Ok(())
}
