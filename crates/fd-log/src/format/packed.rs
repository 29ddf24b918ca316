//! Text that is packed by gzip or Zstandard, unpacked while it is read.
//!
//! Two bounds keep a small file from becoming a large memory: the unpacked text may have at most
//! [`MOST_BYTES`](crate::MOST_BYTES), and a line of it at most [`MOST_LINE`] bytes.

use std::io::{self, BufReader, Read};

use super::zstd::Frames;
use crate::{limit::MOST_BYTES, source::Unsound};
use flate2::bufread::MultiGzDecoder;

/// Most bytes of a line of packed text.
const MOST_LINE: u64 = 16 << 20;
const GZIP: &str = "gzip";
const ZSTD: &str = "Zstandard";

/// The text in a file of gzip.
pub(super) fn gzip(from: impl Read + 'static) -> Box<dyn Read> {
    let unpacked = MultiGzDecoder::new(BufReader::new(from));
    Box::new(Bounded::new(GZIP, unpacked, MOST_BYTES))
}

/// The text in a file of Zstandard.
pub(super) fn zstd(from: impl Read + 'static) -> Box<dyn Read> {
    let frames = Frames::new(BufReader::new(from));
    Box::new(Bounded::new(ZSTD, frames, MOST_BYTES))
}

fn unsound(format: &'static str, found: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, Unsound { format, found: found.into() })
}

/// A reader that stops with an error instead of filling the memory.
struct Bounded<R> {
    format: &'static str,
    from: R,
    left: u64,
    line: u64,
}

impl<R> Bounded<R> {
    fn new(format: &'static str, from: R, most: u64) -> Self {
        Self { format, from, left: most, line: 0 }
    }
}

impl<R: Read> Read for Bounded<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let read = match self.from.read(into) {
            Err(error) if error.kind() == io::ErrorKind::Interrupted => return Err(error),
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
                return Err(unsound(self.format, "the file ends too early"));
            }
            Err(error) => return Err(unsound(self.format, format!("found: {error}"))),
            Ok(read) => read,
        };
        let new = &into[..read];
        self.left = self.left.checked_sub(read as u64).ok_or_else(|| {
            unsound(self.format, format!("found more than {MOST_BYTES} unpacked bytes"))
        })?;
        self.line = match new.iter().rposition(|byte| *byte == b'\n') {
            Some(end) => (read - end - 1) as u64,
            None => self.line + read as u64,
        };
        if self.line > MOST_LINE {
            let found = format!("found a line of more than {MOST_LINE} bytes");
            return Err(unsound(self.format, found));
        }
        Ok(read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_than_the_bound_and_endless_lines_are_errors() {
        let read = |text: Vec<u8>, most| {
            let mut bounded = Bounded::new(GZIP, io::Cursor::new(text), most);
            io::copy(&mut bounded, &mut io::sink()).map_err(|error| error.to_string())
        };
        assert_eq!(read(b"1\n2\n3".to_vec(), 5), Ok(5));
        assert!(read(b"1\n2\n3".to_vec(), 4).is_err_and(|e| e.contains("unpacked bytes")));
        let long = vec![b'0'; 17 << 20];
        assert!(read(long, 1 << 40).is_err_and(|e| e.contains("a line of more than")));
        let lines = b"0123456\n".repeat(17 << 17);
        assert_eq!(read(lines, 1 << 40), Ok(17 << 20));
    }
}
