//! The circular block bootstrap.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Endless sample indices: blocks of consecutive samples of a record closed to a circle, each starting
/// anywhere with equal probability.
#[derive(Clone, Debug)]
pub struct CircularBlocks {
    samples: usize,
    block: usize,
    at: usize,
    left: usize,
    random: Xoshiro256PlusPlus,
}

impl CircularBlocks {
    /// Indices below `samples`, of which there must be at least one, in blocks of `block`; the seed
    /// settles all of them.
    ///
    /// ```
    /// use fd_compensate::calibrate::CircularBlocks;
    ///
    /// let drawn: Vec<usize> = CircularBlocks::new(10, 4, 7).take(8).collect();
    /// assert_eq!(drawn[1], (drawn[0] + 1) % 10);
    /// assert_eq!(drawn, CircularBlocks::new(10, 4, 7).take(8).collect::<Vec<_>>());
    /// ```
    #[must_use]
    pub fn new(samples: usize, block: usize, seed: u64) -> Self {
        let random = Xoshiro256PlusPlus::seed_from_u64(seed);
        Self { samples: samples.max(1), block: block.max(1), at: 0, left: 0, random }
    }

    /// Begins a new block with the next index.
    pub(super) fn restart(&mut self) {
        self.left = 0;
    }
}

impl Iterator for CircularBlocks {
    type Item = usize;

    fn next(&mut self) -> Option<usize> {
        if self.left == 0 {
            self.left = self.block;
            // Drawn as u64, so that the same seed means the same on every machine.
            let start = self.random.random_range(0..self.samples as u64);
            self.at = usize::try_from(start).unwrap_or(0);
        } else {
            self.at = (self.at + 1) % self.samples;
        }
        self.left -= 1;
        Some(self.at)
    }
}
