//! Tapes (inputs and forces of whole runs) that were gone through before, and what is foreseen by them.

use std::sync::Mutex;

use super::lock::open;

/// The first tapes are those of the logs: so many of these are remembered …
const FIRST: usize = 4;
/// … and so many of the last ones, those of every trial that is at work on some thread among them …
const LAST: usize = 64;
/// … while all of them have at most so many numbers (32 MB).
const MOST: usize = 4 << 20;

/// Inputs and forces of whole runs.
#[derive(Debug, Default)]
pub(super) struct Tapes(Mutex<Vec<KnownTape>>);

/// Those of one run.
#[derive(Debug)]
struct KnownTape {
    /// Number of the first sample.
    first: u64,
    rows: Vec<f64>,
}

/// Whether both are the same to the bit.
fn is_same(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
}

impl Tapes {
    /// Remembers the tape of a whole run.
    pub(super) fn note(&self, first: u64, rows: &[f64]) {
        let mut known = open(&self.0);
        if known.iter().any(|tape| tape.first == first && is_same(&tape.rows, rows)) {
            return;
        }
        let is_full = |known: &[KnownTape]| {
            FIRST + LAST <= known.len()
                || MOST < known.iter().map(|tape| tape.rows.len()).sum::<usize>() + rows.len()
        };
        while FIRST < known.len() && is_full(&known) {
            known.remove(FIRST);
        }
        known.push(KnownTape { first, rows: rows.to_vec() });
    }

    /// What comes after the rows of a run so far in a known one that has begun like it: that run is remembered, where its
    /// parameters are the same.
    pub(super) fn rest(&self, first: u64, rows: &[f64]) -> Option<Vec<f64>> {
        let known = open(&self.0);
        let mut same = known.iter().rev().filter(|tape| tape.first == first);
        same.find_map(|tape| {
            let (so_far, rest) = tape.rows.split_at_checked(rows.len())?;
            (is_same(so_far, rows) && !rest.is_empty()).then(|| rest.to_vec())
        })
    }

    /// At most so many rows that may come after a row at a sample: with the inputs, of which there are `nu`, of the
    /// latest run that had the same there, and with the forces as they are now.
    pub(super) fn after(
        &self,
        sample: u64,
        row: &[f64],
        nu: usize,
        most: usize,
    ) -> Option<Vec<f64>> {
        let (u, f) = row.split_at(nu);
        open(&self.0).iter().rev().find_map(|tape| {
            let place = usize::try_from(sample.checked_sub(tape.first)?).ok()?;
            let mut known = tape.rows.chunks_exact(row.len().max(1)).map(|row| &row[..nu]);
            known.nth(place).filter(|now| is_same(now, u))?;
            let next: Vec<f64> = known.take(most).flat_map(|u| [u, f].concat()).collect();
            Some(next).filter(|next| !next.is_empty())
        })
    }
}

/// The samples after those that were asked for.
#[derive(Debug, Default)]
pub(super) struct Foreseen {
    /// The sample that comes first.
    pub begin: usize,
    pub rows: Vec<f64>,
    pub y: Vec<f64>,
}

impl Foreseen {
    /// Forgets everything if the row at a sample is another one.
    pub(super) fn follow(&mut self, sample: usize, row: &[f64]) {
        if !self.rows.is_empty() {
            let known = sample.checked_sub(self.begin).map(|i| i * row.len()..(i + 1) * row.len());
            if !known
                .and_then(|known| self.rows.get(known))
                .is_some_and(|known| is_same(known, row))
            {
                *self = Self::default();
            }
        }
    }

    /// The outputs at a sample, if they are there.
    pub(super) fn at(&self, sample: usize, ny: usize) -> Option<&[f64]> {
        let place = sample.checked_sub(self.begin)?;
        self.y.get(place * ny..(place + 1) * ny)
    }
}
