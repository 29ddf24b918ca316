//! How much of what a broker has sent may wait to be judged.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// Bytes of messages that may wait: beyond them the broker has to. One message may be larger than that.
const MOST: usize = 8 << 20;

/// Bytes that wait.
#[derive(Default)]
pub(super) struct Backlog {
    bytes: Mutex<usize>,
    has_shrunk: Condvar,
}

impl Backlog {
    fn lock(&self) -> MutexGuard<'_, usize> {
        self.bytes.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until there is room for so many bytes; they have it until what is returned is dropped.
    pub(super) fn admit(self: &Arc<Self>, bytes: usize) -> Admitted {
        let is_full = |waiting: &mut usize| 0 < *waiting && MOST < waiting.saturating_add(bytes);
        let waited = self.has_shrunk.wait_while(self.lock(), is_full);
        *waited.unwrap_or_else(PoisonError::into_inner) += bytes;
        Admitted { backlog: Arc::clone(self), bytes }
    }
}

/// The room of a message that waits.
pub(in super::super) struct Admitted {
    backlog: Arc<Backlog>,
    bytes: usize,
}

impl Drop for Admitted {
    fn drop(&mut self) {
        *self.backlog.lock() -= self.bytes;
        self.backlog.has_shrunk.notify_one();
    }
}

#[cfg(test)]
mod tests {
    use std::{sync::Arc, time::Duration};

    use super::{Backlog, MOST};

    #[test]
    fn whoever_comes_when_it_is_full_waits_until_somebody_has_gone() {
        let backlog = Arc::new(Backlog::default());
        // One of any size, when nobody else is there.
        let first = backlog.admit(2 * MOST);
        let also = Arc::clone(&backlog);
        let second = std::thread::spawn(move || drop(also.admit(1)));
        std::thread::sleep(Duration::from_millis(50));
        assert!(!second.is_finished());
        drop(first);
        second.join().unwrap();
        let _both = [backlog.admit(MOST - 1), backlog.admit(1)];
    }
}
