//! Many connections: most of them at once, and who has to go when there are more.

use std::{
    collections::VecDeque,
    io,
    net::{Shutdown, TcpStream},
    sync::{
        Mutex, MutexGuard, PoisonError,
        atomic::{AtomicUsize, Ordering},
    },
};

/// Most connections that are served at once, live pages not included. A browser opens six for a page.
pub(super) const MOST: usize = 64;

/// Connections whose request has not been answered yet, oldest first.
#[derive(Default)]
pub(super) struct Crowd {
    waiting: Mutex<VecDeque<(u64, TcpStream)>>,
}

impl Crowd {
    fn lock(&self) -> MutexGuard<'_, VecDeque<(u64, TcpStream)>> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Lets a connection in. When there are too many, the one that has taken longest is cut off: whoever asks at once is
    /// answered, however many others keep silent.
    pub(super) fn enter(&self, number: u64, stream: &TcpStream) -> io::Result<()> {
        let stream = stream.try_clone()?;
        let mut waiting = self.lock();
        waiting.push_back((number, stream));
        if MOST < waiting.len()
            && let Some((_, oldest)) = waiting.pop_front()
        {
            // It may have gone already.
            let _ = oldest.shutdown(Shutdown::Both);
        }
        Ok(())
    }

    pub(super) fn leave(&self, number: u64) {
        self.lock().retain(|(waiting, _)| *waiting != number);
    }
}

/// Places of which there are a few, given back when dropped.
pub(super) struct Places {
    taken: AtomicUsize,
    most: usize,
}

pub(super) struct Place<'a>(&'a Places);

impl Places {
    pub(super) const fn new(most: usize) -> Self {
        Self { taken: AtomicUsize::new(0), most }
    }

    pub(super) fn take(&self) -> Option<Place<'_>> {
        let place = (self.taken.fetch_add(1, Ordering::Relaxed), Place(self));
        (place.0 < self.most).then_some(place.1)
    }
}

impl Drop for Place<'_> {
    fn drop(&mut self) {
        self.0.taken.fetch_sub(1, Ordering::Relaxed);
    }
}
