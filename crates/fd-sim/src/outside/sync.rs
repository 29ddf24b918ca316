//! What threads meet at in the [pool](super::pool): that of the standard library, or that of loom, which goes through all
//! orders in which threads can meet (`cargo test -p fd-sim --features loom --lib pool`).

#[cfg(not(all(test, feature = "loom")))]
mod real {
    use std::{sync::Condvar, time::Duration};
    pub(crate) use std::{
        sync::{Mutex, MutexGuard, atomic::AtomicU64},
        thread::{ThreadId, current},
        time::Instant,
    };

    use super::super::lock::open;

    /// How long it is waited before looking again.
    const LOOK: Duration = Duration::from_millis(2);

    /// Rung when something has changed. Who does not hear it looks again soon.
    #[derive(Debug, Default)]
    pub(crate) struct Bell(Mutex<()>, Condvar);

    impl Bell {
        pub(crate) fn ring(&self) {
            self.1.notify_one();
        }

        pub(crate) fn wait(&self) {
            // Rung or not, it is looked again.
            drop(self.1.wait_timeout(open(&self.0), LOOK));
        }
    }
}

/// Time is no part of it: whether a simulator was idle for long is the same throughout a model.
#[cfg(all(test, feature = "loom"))]
mod modelled {
    use std::{cell::Cell, sync::PoisonError, time::Duration};

    pub(crate) use loom::{
        sync::{Mutex, MutexGuard, atomic::AtomicU64},
        thread::{ThreadId, current},
    };

    std::thread_local! {
        /// Whether every simulator counts as idle. The threads of a model are one.
        pub(crate) static IS_LATE: Cell<bool> = const { Cell::new(false) };
    }

    pub(crate) fn open<T>(lock: &Mutex<T>) -> MutexGuard<'_, T> {
        lock.lock().unwrap_or_else(PoisonError::into_inner)
    }

    #[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
    pub(crate) struct Instant;

    impl Instant {
        pub(crate) fn now() -> Self {
            Self
        }

        pub(crate) fn elapsed(self) -> Duration {
            if IS_LATE.get() { Duration::MAX } else { Duration::ZERO }
        }
    }

    /// Never heard: whoever waits lets the others go on, and looks again.
    #[derive(Debug, Default)]
    pub(crate) struct Bell;

    impl Bell {
        pub(crate) fn ring(&self) {}

        pub(crate) fn wait(&self) {
            loom::thread::yield_now();
        }
    }
}

#[cfg(all(test, feature = "loom"))]
pub(super) use self::modelled::*;
#[cfg(not(all(test, feature = "loom")))]
pub(super) use self::real::*;
#[cfg(not(all(test, feature = "loom")))]
pub(super) use super::lock::open;
