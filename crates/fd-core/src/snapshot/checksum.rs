//! A sum that shows whether anything was changed.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::field::Field;

/// Odd, with its bits well spread: the golden ratio in 64 bits.
const FACTOR: u64 = 0x9E37_79B9_7F4A_7C15;

/// A checksum of names and numbers, sixteen hexadecimal digits.
///
/// Each step `s ← (s ⊕ w)·f`, turned by 29 bits, can be undone when the word `w` is known, and has
/// another result for every other `w`. So two snapshots that differ in one number never have the same
/// sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Checksum(u64);

impl Checksum {
    pub(super) fn of(fields: &[Field]) -> Self {
        let mut sum = FACTOR;
        let mut add = |word: u64| sum = (sum ^ word).wrapping_mul(FACTOR).rotate_left(29);
        add(fields.len() as u64);
        for Field { name, bits } in fields {
            // Lengths first: nothing can move from one field to the next.
            add(name.len() as u64);
            name.bytes().for_each(|byte| add(u64::from(byte)));
            add(bits.len() as u64);
            for word in bits {
                add(*word);
            }
        }
        Self(sum)
    }
}

impl fmt::Display for Checksum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}
