//! Work for several copies of a simulator at the same time.

use std::{
    sync::{Mutex, PoisonError},
    thread,
};

/// Does pieces of work on at most so many threads; on this one where one is enough.
pub(crate) fn on_workers<T: Send>(workers: usize, work: Vec<T>, act: impl Fn(T) + Sync) {
    let threads = workers.min(work.len());
    if threads < 2 {
        work.into_iter().for_each(act);
        return;
    }
    let queue = Mutex::new(work.into_iter());
    let next = || queue.lock().unwrap_or_else(PoisonError::into_inner).next();
    thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                while let Some(piece) = next() {
                    act(piece);
                }
            });
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_piece_is_done_once_by_any_number_of_workers() {
        for workers in 0..5 {
            let mut done = [0; 7];
            on_workers(workers, done.iter_mut().collect(), |piece| *piece += 1);
            assert_eq!(done, [1; 7]);
        }
    }
}
