//! Work on all threads, compiled once: iterators of rayon are compiled again for each use, and were a ninth of this crate.

use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

/// What is made of each piece, in the order of the pieces.
pub(crate) fn each<T: Send, R: Send>(
    pieces: impl IntoIterator<Item = T>,
    make: impl Fn(T) -> R + Sync,
) -> Vec<R> {
    let places: Vec<_> = pieces.into_iter().map(|piece| Mutex::new((Some(piece), None))).collect();
    on_all_threads(places.len(), &|at| {
        // Nobody else comes to this place: the lock is for the compiler.
        let mut place = places[at].lock().unwrap_or_else(PoisonError::into_inner);
        place.1 = place.0.take().map(&make);
    });
    let made = places.into_iter().map(Mutex::into_inner);
    made.filter_map(|place| place.unwrap_or_else(PoisonError::into_inner).1).collect()
}

fn on_all_threads(pieces: usize, act: &(dyn Fn(usize) + Sync)) {
    (0..pieces).into_par_iter().for_each(act);
}

#[cfg(test)]
mod tests {
    use super::each;

    #[test]
    fn each_piece_is_done_once_and_stays_in_its_place() {
        let mut pieces: Vec<usize> = (0..100).collect();
        let add = |piece: &mut usize| {
            *piece += 1;
            // Within the work for another piece as well.
            each(0..*piece, |i| i).len()
        };
        let expected: Vec<usize> = (1..101).collect();
        assert_eq!(each(&mut pieces, add), expected);
        assert_eq!(pieces, expected);
    }
}
