//! Text that is packed by gzip or Zstandard, unpacked while it is read.
//!
//! Bounds keep a small file from becoming a large memory or a long wait: the unpacked text may have at most
//! [`MOST_BYTES`](crate::MOST_BYTES), and its lines are [bounded](super::bounded) as those of any text.

use std::io::{BufReader, Read};

use flate2::bufread::MultiGzDecoder;

use super::{bounded::Bounded, zstd::Frames};
use crate::limit::MOST_BYTES;

/// The text in a file of gzip.
pub(super) fn gzip(from: impl Read + 'static) -> Box<dyn Read> {
    let unpacked = MultiGzDecoder::new(BufReader::new(from));
    Box::new(Bounded::new("gzip", unpacked, MOST_BYTES))
}

/// The text in a file of Zstandard.
pub(super) fn zstd(from: impl Read + 'static) -> Box<dyn Read> {
    let frames = Frames::new(BufReader::new(from));
    Box::new(Bounded::new("Zstandard", frames, MOST_BYTES))
}
