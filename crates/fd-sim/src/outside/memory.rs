//! A cache of runs: what was simulated before is not simulated again.

use std::{collections::HashMap, sync::Mutex};

use super::lock::open;

/// Most numbers that are kept, overheads among them: 64 MB.
const MOST: usize = 8 << 20;
/// What an entry costs beyond its numbers, in numbers.
const OVERHEAD: usize = 8;

/// The past of a run: its parameters, start, inputs and forces up to some sample.
///
/// Two independent chains of 64 bits, each a bijection of what came before and the new number: two pasts that
/// differ have the same key once in 2^128.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Past([u64; 2]);

/// Finaliser of `MurmurHash3` (A. Appleby, public domain): each bit in changes half the bits out.
fn mix(mut h: u64) -> u64 {
    h = (h ^ (h >> 33)).wrapping_mul(0xff51_afd7_ed55_8ccd);
    h = (h ^ (h >> 33)).wrapping_mul(0xc4ce_b9fe_1a85_ec53);
    h ^ (h >> 33)
}

impl Past {
    /// The past with one more number.
    pub(super) fn with(self, word: u64) -> Self {
        let [a, b] = self.0;
        let other = word.rotate_left(32) ^ 0x9e37_79b9_7f4a_7c15;
        Self([mix(a ^ word), mix(b.wrapping_add(other))])
    }

    /// The past with more values.
    pub(super) fn and(self, values: &[f64]) -> Self {
        values.iter().fold(self, |past, value| past.with(value.to_bits()))
    }
}

/// Results of pasts, the oldest forgotten first: the younger of two generations takes what is new, and what
/// of the older is used again; when it is full the older one goes.
#[derive(Debug, Default)]
pub(super) struct Memory(Mutex<Generations>);

#[derive(Debug, Default)]
struct Generations {
    young: HashMap<Past, Box<[f64]>>,
    old: HashMap<Past, Box<[f64]>>,
    /// Numbers in the younger one.
    size: usize,
}

impl Generations {
    fn put(&mut self, past: Past, values: Box<[f64]>) {
        let size = values.len() + OVERHEAD;
        if MOST / 2 < self.size + size {
            self.old = std::mem::take(&mut self.young);
            self.size = 0;
        }
        // What is larger than everything together is not kept.
        if size <= MOST / 2 && self.young.insert(past, values).is_none() {
            self.size += size;
        }
    }
}

impl Memory {
    /// Writes the values of a past one after another into these parts, if they are known.
    pub(super) fn recall(&self, past: Past, parts: [&mut [f64]; 2]) -> bool {
        let mut generations = open(&self.0);
        if !generations.young.contains_key(&past) {
            match generations.old.remove(&past) {
                Some(values) => generations.put(past, values),
                None => return false,
            }
        }
        let Some(values) = generations.young.get(&past) else { return false };
        let [first, second] = parts;
        if values.len() != first.len() + second.len() {
            return false;
        }
        let (a, b) = values.split_at(first.len());
        first.copy_from_slice(a);
        second.copy_from_slice(b);
        true
    }

    pub(super) fn keep(&self, past: Past, parts: [&[f64]; 2]) {
        let values = parts.concat().into_boxed_slice();
        open(&self.0).put(past, values);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_is_recalled_and_the_oldest_is_forgotten() {
        let memory = Memory::default();
        let past = |i: usize| Past::default().and(&[i as f64, 0.5]);
        let size = 1000;
        let values = |i: usize| vec![i as f64; size];
        let n = 2 * MOST / (size + OVERHEAD);
        for i in 0..n {
            memory.keep(past(i), [&values(i), &[]]);
            // The first one is asked for all the time.
            assert!(memory.recall(past(0), [&mut values(1), &mut []]), "{i}");
        }
        let mut y = values(0);
        assert!(memory.recall(past(n - 1), [&mut y, &mut []]));
        assert_eq!(y, values(n - 1));
        assert!(!memory.recall(past(1), [&mut y, &mut []]));
        let generations = memory.0.lock().unwrap();
        assert!((generations.young.len() + generations.old.len()) * (size + OVERHEAD) <= MOST);
    }

    #[test]
    fn pasts_differ_by_order_sign_and_length() {
        let pasts = [
            Past::default(),
            Past::default().and(&[0.0]),
            Past::default().and(&[-0.0]),
            Past::default().and(&[0.0, 0.0]),
            Past::default().and(&[1.0, 2.0]),
            Past::default().and(&[2.0, 1.0]),
        ];
        for (i, a) in pasts.iter().enumerate() {
            assert!(pasts[..i].iter().all(|b| a != b), "{i}");
        }
    }
}
