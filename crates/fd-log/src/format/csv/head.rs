//! The beginning of a file: its encoding, what stands before the header, and where in the file rows are.

use std::io::{self, Cursor, Read};

use super::utf16::Utf16;
use crate::{error::LogError, source::cannot_read};

/// Bytes at the beginning of a file that its form is found from; more only where no header is within them.
const LOOKED_AT: u64 = 1 << 16;
/// Bytes of comments and blank lines before the header.
const MOST_COMMENTS: u64 = 16 << 20;
const UTF8_MARK: &[u8] = b"\xEF\xBB\xBF";

/// Text of one byte a character or several, whatever the file has.
#[derive(Debug)]
pub(super) enum Text<R> {
    Bytes(R),
    Utf16(Utf16<R>),
}

impl<R: Read> Read for Text<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Bytes(from) => from.read(into),
            Self::Utf16(from) => from.read(into),
        }
    }
}

/// The beginning of a file.
#[derive(Debug)]
pub(super) struct Head {
    /// From the first line on that is neither blank nor a comment.
    pub block: Vec<u8>,
    /// Whether that is all that follows.
    pub is_whole: bool,
    pub lines_before: u64,
    /// Whether the file begins with the version line of the format.
    pub written_here: bool,
    pub sample_time: Option<f64>,
    pub is_utf16: bool,
}

impl Head {
    /// Reads it; what follows is left in the reader.
    pub(super) fn read<R: Read>(file: &str, mut from: R) -> Result<(Self, Text<R>), LogError> {
        let unreadable = |error| cannot_read(file, &error);
        let mut mark = Vec::new();
        from.by_ref().take(UTF8_MARK.len() as u64).read_to_end(&mut mark).map_err(unreadable)?;
        let utf16 = match mark[..] {
            [0xff, 0xfe, ..] => Some(false),
            [0xfe, 0xff, ..] => Some(true),
            _ => None,
        };
        let (mut block, mut from) = match utf16 {
            Some(is_big_endian) => {
                (Vec::new(), Text::Utf16(Utf16::new(&mark[2..], from, is_big_endian)))
            }
            None if mark == UTF8_MARK => (Vec::new(), Text::Bytes(from)),
            None => (mark, Text::Bytes(from)),
        };
        let mut head = Self {
            block: Vec::new(),
            is_whole: false,
            lines_before: 0,
            written_here: false,
            sample_time: None,
            is_utf16: utf16.is_some(),
        };
        let mut passed = 0;
        loop {
            let read = (&mut from).take(LOOKED_AT).read_to_end(&mut block).map_err(unreadable)?;
            head.is_whole = (read as u64) < LOOKED_AT;
            let mut begin = 0;
            while let Some(length) = line(&block[begin..], head.is_whole) {
                let line = &block[begin..begin + length];
                if !line.starts_with(b"#") && !line.trim_ascii().is_empty() {
                    head.block = block.split_off(begin);
                    return Ok((head, from));
                }
                if line.starts_with(b"#") {
                    head.comment(file, line)?;
                }
                head.lines_before += 1;
                begin += length;
            }
            if head.is_whole {
                return Err(LogError::Empty { file: file.to_owned() });
            }
            block.drain(..begin);
            passed += begin as u64;
            if passed + block.len() as u64 > MOST_COMMENTS {
                let (file, expected) = (file.to_owned(), "a header");
                let found = format!("found only comments in its first {MOST_COMMENTS} bytes");
                return Err(LogError::NoLog { file, expected, found });
            }
        }
    }

    /// Reads `# fdiag-log version=1 sample_time=0.1`; any other comment is skipped.
    fn comment(&mut self, file: &str, line: &[u8]) -> Result<(), LogError> {
        let text = String::from_utf8_lossy(line);
        let mut words = text.trim_start_matches('#').split_whitespace();
        if self.lines_before > 0 || words.next() != Some("fdiag-log") {
            return Ok(());
        }
        self.written_here = true;
        for (key, value) in words.filter_map(|word| word.split_once('=')) {
            match key {
                "version" if value != "1" => {
                    let (file, found) = (file.to_owned(), value.to_owned());
                    return Err(LogError::Version { file, found });
                }
                "sample_time" => {
                    let wrong = |_| LogError::Number {
                        file: file.to_owned(),
                        column: key.to_owned(),
                        row: 1,
                        found: value.to_owned(),
                    };
                    self.sample_time = Some(value.parse().map_err(wrong)?);
                }
                _ => {}
            }
        }
        Ok(())
    }
}

/// Length of the first line with its end; of a line without one only where nothing follows, or it is a header already.
fn line(bytes: &[u8], is_whole: bool) -> Option<usize> {
    if bytes.is_empty() {
        return None;
    }
    let end = bytes.iter().position(|byte| *byte == b'\n').map(|at| at + 1);
    let is_header = !bytes.starts_with(b"#") && !bytes.trim_ascii().is_empty();
    end.or((is_whole || is_header).then_some(bytes.len()))
}

/// From the line counts of the CSV reader to lines of the file.
#[derive(Clone, Copy, Debug)]
pub(super) struct LineCounter {
    pub before_header: u64,
    pub crlf: bool,
}

impl LineCounter {
    /// Line of the record between whose start and end the reader counted `before` and `after`.
    ///
    /// The reader skips blank lines at the start of a record, and takes the second byte of a
    /// CR LF for one of those.
    pub(super) fn row(self, before: u64, after: u64) -> u64 {
        let line = if self.crlf { after.max(before + 1) } else { before.max(after - 1) };
        self.before_header + line
    }
}

/// What is read: the beginning again, and what follows.
pub(super) type Whole<R> = io::Chain<Cursor<Vec<u8>>, Text<R>>;
