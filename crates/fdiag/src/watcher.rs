//! How far an experiment has come: one contract for all of them.

/// Somebody who watches work of many alike pieces: engines, cases, logs.
///
/// (A diagnosis has stages of different kinds and a contract of its own, `fd_gap::diagnose::Monitor`.)
///
/// ```
/// use std::sync::atomic::{AtomicU64, Ordering};
///
/// use fdiag::Watcher;
///
/// /// Counts what is still to be done.
/// struct Left(AtomicU64);
///
/// impl Watcher for Left {
///     fn begin(&self, pieces: u64, done: u64) {
///         self.0.store(pieces - done, Ordering::Relaxed);
///     }
///
///     fn advance(&self) {
///         self.0.fetch_sub(1, Ordering::Relaxed);
///     }
/// }
///
/// let left = Left(AtomicU64::new(0));
/// left.begin(10, 4);
/// left.advance();
/// assert_eq!(left.0.into_inner(), 5);
/// ```
pub trait Watcher: Sync {
    /// So many pieces are to be done, of which some are done already.
    fn begin(&self, pieces: u64, done: u64);
    /// One more is done; from any thread.
    fn advance(&self);
    /// Step `step` of the `steps` of a piece is done, counted from 1; from any thread. For pieces that take long: whoever
    /// waits sees at once that it goes on. Steps need not take equally long, and may be left out.
    fn step(&self, _step: usize, _steps: usize) {}
    /// Whether nobody wants to wait any longer: pieces that were not begun are left out.
    fn is_stopped(&self) -> bool {
        false
    }
}

/// Nobody.
impl Watcher for () {
    fn begin(&self, _pieces: u64, _done: u64) {}
    fn advance(&self) {}
}
