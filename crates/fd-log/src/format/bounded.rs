//! Text that cannot become a large memory, or a long wait for nothing.

use std::io::{self, Read};

use crate::{error::LogError, source::Unsound};

/// Most bytes of a line.
const MOST_LINE: u64 = 16 << 20;
/// Most bytes of blank lines one after the other.
const MOST_BLANK: u64 = 16 << 20;

/// A reader that stops with an error: beyond so many bytes in all, in an endless line, in blank lines without end.
pub(super) struct Bounded<R> {
    format: &'static str,
    from: R,
    most: u64,
    read: u64,
    line: u64,
    blank: u64,
}

impl<R> Bounded<R> {
    pub(super) fn new(format: &'static str, from: R, most: u64) -> Self {
        Self { format, from, most, read: 0, line: 0, blank: 0 }
    }

    fn unsound(&self, found: impl Into<String>) -> io::Error {
        let unsound = Unsound { format: self.format, found: found.into() };
        io::Error::new(io::ErrorKind::InvalidData, unsound)
    }
}

/// Bytes behind the last one that is meant, in what was read and in what was before it.
fn behind(new: &[u8], before: u64, is_meant: impl Fn(&u8) -> bool) -> u64 {
    match new.iter().rposition(is_meant) {
        Some(last) => (new.len() - last - 1) as u64,
        None => before + new.len() as u64,
    }
}

impl<R: Read> Read for Bounded<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let read = match self.from.read(into) {
            Err(error) if error.kind() == io::ErrorKind::Interrupted => return Err(error),
            // Of a file as it is, what the system says is all there is to say.
            Err(error) if self.most == u64::MAX => return Err(error),
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
                return Err(self.unsound("the file ends too early"));
            }
            Err(error) => return Err(self.unsound(format!("found: {error}"))),
            Ok(read) => read,
        };
        let new = &into[..read];
        self.read = self.read.saturating_add(read as u64);
        self.line = behind(new, self.line, |byte| *byte == b'\n');
        self.blank = behind(new, self.blank, |byte| !byte.is_ascii_whitespace());
        if self.read > self.most {
            let found = format!("found more than {} unpacked bytes", self.most);
            return Err(self.unsound(found));
        }
        if self.line > MOST_LINE {
            return Err(self.unsound(format!("found a line of more than {MOST_LINE} bytes")));
        }
        if self.blank > MOST_BLANK {
            let found = format!("found more than {MOST_BLANK} bytes of blank lines");
            return Err(self.unsound(found));
        }
        Ok(read)
    }
}

/// Most columns of a text.
const MOST_COLUMNS: usize = 10_000;

/// Refuses a header whose columns would be a memory of their own.
pub(super) fn check_columns(file: &str, found: usize) -> Result<(), LogError> {
    if found <= MOST_COLUMNS {
        return Ok(());
    }
    let (file, found) = (file.to_owned(), format!("found {found}"));
    Err(LogError::NoLog { file, expected: "at most 10000 columns", found })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_than_the_bound_and_endless_lines_are_errors() {
        let read = |text: Vec<u8>, most| {
            let mut bounded = Bounded::new("gzip", io::Cursor::new(text), most);
            io::copy(&mut bounded, &mut io::sink()).map_err(|error| error.to_string())
        };
        assert_eq!(read(b"1\n2\n3".to_vec(), 5), Ok(5));
        assert!(read(b"1\n2\n3".to_vec(), 4).is_err_and(|e| e.contains("unpacked bytes")));
        let long = vec![b'0'; 17 << 20];
        assert!(read(long, 1 << 40).is_err_and(|e| e.contains("a line of more than")));
        let lines = b"0123456\n".repeat(17 << 17);
        assert_eq!(read(lines, 1 << 40), Ok(17 << 20));
        let blank = [b"1\n".to_vec(), b" \r\n".repeat(6 << 20)].concat();
        assert!(read(blank, 1 << 40).is_err_and(|e| e.contains("of blank lines")));
    }
}
