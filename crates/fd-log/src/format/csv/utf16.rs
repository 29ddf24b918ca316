//! UTF-16 as UTF-8, while it is read.

use std::io::{self, Read};

/// Bytes that are read at a time.
const PIECE: usize = 1 << 13;

/// A reader of the same text in UTF-8. Halves of characters that stand alone become U+FFFD.
#[derive(Debug)]
pub(super) struct Utf16<R> {
    from: R,
    is_big_endian: bool,
    /// Bytes and half a character that wait for their other half.
    odd: Option<u8>,
    high: Option<u16>,
    ready: Vec<u8>,
    taken: usize,
}

impl<R: Read> Utf16<R> {
    /// `begun` are bytes that were read already; at most one.
    pub(super) fn new(begun: &[u8], from: R, is_big_endian: bool) -> Self {
        let odd = begun.first().copied();
        Self { from, is_big_endian, odd, high: None, ready: Vec::new(), taken: 0 }
    }

    /// Reads on; false at the end.
    fn fill(&mut self) -> io::Result<bool> {
        let mut raw = [0; PIECE];
        let read = self.from.read(&mut raw)?;
        let bytes = self.odd.take().into_iter().chain(raw[..read].iter().copied());
        let bytes: Vec<u8> = bytes.collect();
        let (pairs, odd) = bytes.as_chunks::<2>();
        self.odd = odd.first().copied();
        let unit = |pair: &[u8; 2]| {
            if self.is_big_endian { u16::from_be_bytes(*pair) } else { u16::from_le_bytes(*pair) }
        };
        let mut units: Vec<u16> =
            self.high.take().into_iter().chain(pairs.iter().map(unit)).collect();
        let is_half = |unit: &u16| (0xd800..0xdc00).contains(unit);
        if read > 0 && units.last().is_some_and(is_half) {
            self.high = units.pop();
        }
        let text: String = char::decode_utf16(units)
            .map(|character| character.unwrap_or(char::REPLACEMENT_CHARACTER))
            .collect();
        (self.ready, self.taken) = (text.into_bytes(), 0);
        Ok(read > 0)
    }
}

impl<R: Read> Read for Utf16<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        while self.taken == self.ready.len() {
            if !self.fill()? && self.ready.is_empty() {
                return Ok(0);
            }
        }
        let rest = &self.ready[self.taken..];
        let count = rest.len().min(into.len());
        into[..count].copy_from_slice(&rest[..count]);
        self.taken += count;
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_orders_are_read_whatever_the_pieces() {
        /// Hands out a few bytes at a time.
        struct Slow<'a>(&'a [u8], usize);
        impl Read for Slow<'_> {
            fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
                let count = self.1.min(into.len());
                self.0.read(&mut into[..count])
            }
        }
        let text = "Zeit;T [°C];𝄞\n0;1\n".repeat(1000);
        for is_big_endian in [false, true] {
            let bytes =
                |unit: u16| if is_big_endian { unit.to_be_bytes() } else { unit.to_le_bytes() };
            let bytes: Vec<u8> = text.encode_utf16().flat_map(bytes).collect();
            // Odd pieces split units, and those of two bytes the halves of a character.
            for piece in [1, 2, 7, bytes.len()] {
                let mut found = String::new();
                Utf16::new(&[], Slow(&bytes, piece), is_big_endian)
                    .read_to_string(&mut found)
                    .unwrap();
                assert_eq!(found, text);
            }
        }
    }
}
