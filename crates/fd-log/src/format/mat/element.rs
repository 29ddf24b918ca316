//! Elements: a type, a length, and so many bytes, filled up to eight.

use std::io::Read;

use flate2::read::ZlibDecoder;

use super::super::number::Number;
use crate::{error::LogError, limit::Budget};

/// Bytes that are unpacked at a time.
const PIECE: u64 = 1 << 20;

/// One element.
#[derive(Clone, Copy, Debug)]
pub(super) struct Element<'a> {
    /// Its type.
    pub kind: u32,
    /// What is in it.
    pub data: &'a [u8],
}

impl Element<'_> {
    /// An array with its name.
    pub(super) const MATRIX: u32 = 14;
    /// Another element, packed by zlib.
    pub(super) const COMPRESSED: u32 = 15;

    /// How its numbers are stored.
    pub(super) fn number(&self, is_big_endian: bool) -> Option<Number> {
        let kind = match self.kind {
            1 => "i1",
            2 => "u1",
            3 => "i2",
            4 => "u2",
            5 => "i4",
            6 => "u4",
            7 => "f4",
            9 => "f8",
            12 => "i8",
            13 => "u8",
            _ => return None,
        };
        Number::parse(&format!("{}{kind}", if is_big_endian { '>' } else { '<' }))
    }

    /// Its words of 32 bits: flags, dimensions and lengths are such.
    pub(super) fn words(&self, is_big_endian: bool) -> Vec<u32> {
        let word = |cell: &[u8]| {
            let cell = cell.try_into().unwrap_or_default();
            if is_big_endian { u32::from_be_bytes(cell) } else { u32::from_le_bytes(cell) }
        };
        self.data.chunks_exact(4).map(word).collect()
    }

    /// The bytes that are packed in it.
    pub(super) fn unpacked(&self, left: &mut Budget, file: &str) -> Result<Vec<u8>, LogError> {
        let mut packed = ZlibDecoder::new(self.data);
        let mut raw = Vec::new();
        loop {
            // Asked for piece by piece: what is packed may claim any size.
            let before = raw.len();
            left.take("packed data", PIECE)?;
            (&mut packed).take(PIECE).read_to_end(&mut raw).map_err(|error| LogError::Damaged {
                file: file.to_owned(),
                format: "MAT",
                found: format!("found packed data that cannot be unpacked: {error}"),
            })?;
            if raw.len() == before {
                return Ok(raw);
            }
        }
    }
}

/// Elements one behind the other.
pub(super) struct Elements<'a> {
    rest: &'a [u8],
    is_big_endian: bool,
}

impl<'a> Elements<'a> {
    pub(super) fn new(rest: &'a [u8], is_big_endian: bool) -> Self {
        Self { rest, is_big_endian }
    }

    fn word(&self, at: usize) -> Option<u32> {
        let bytes = self.rest.get(at..at + 4)?.try_into().ok()?;
        Some(if self.is_big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
    }

    /// The next one, nothing at the end, and what `damaged` says where it is cut off.
    pub(super) fn next_or(
        &mut self,
        damaged: impl Fn(&str) -> LogError,
    ) -> Result<Option<Element<'a>>, LogError> {
        if self.rest.is_empty() {
            return Ok(None);
        }
        let cut = || damaged("the file ends within an element");
        let first = self.word(0).ok_or_else(cut)?;
        // Up to four bytes stand in the tag itself, with their number in its upper half.
        let (kind, length, begin): (u32, u32, usize) = match first >> 16 {
            0 => (first, self.word(4).ok_or_else(cut)?, 8),
            length @ 1..=4 => (first & 0xffff, length, 4),
            _ => return Err(damaged("found an element of an unknown form")),
        };
        let length = usize::try_from(length).map_err(|_| cut())?;
        let data = self.rest.get(begin..begin.saturating_add(length)).ok_or_else(cut)?;
        let padded = if begin == 4 {
            8
        } else if kind == Element::COMPRESSED {
            begin + length
        } else {
            begin + length.next_multiple_of(8)
        };
        self.rest = self.rest.get(padded..).unwrap_or_default();
        Ok(Some(Element { kind, data }))
    }
}
