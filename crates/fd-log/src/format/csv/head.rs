//! What stands before the rows of a log, and where in the file each row is.

use std::io::{BufRead, BufReader, Read};

use crate::{error::LogError, source::cannot_read};

/// The lines of a file up to and including the header.
pub(super) struct Head {
    pub(super) header: Vec<u8>,
    pub(super) lines_before: u64,
    /// Whether the file begins with the version line of the format.
    pub(super) written_here: bool,
    pub(super) sample_time: Option<f64>,
}

impl Head {
    pub(super) fn read<R: Read>(file: &str, from: R) -> Result<(Self, BufReader<R>), LogError> {
        const UTF8_MARK: &[u8] = b"\xEF\xBB\xBF";
        let mut from = BufReader::new(from);
        let mut head =
            Self { header: Vec::new(), lines_before: 0, written_here: false, sample_time: None };
        loop {
            let mut line = Vec::new();
            from.read_until(b'\n', &mut line).map_err(|error| cannot_read(file, &error))?;
            if head.lines_before == 0 {
                if line.starts_with(b"\xFF\xFE") || line.starts_with(b"\xFE\xFF") {
                    let found = "a UTF-16 byte order mark".to_owned();
                    return Err(LogError::NotUtf8 { file: file.to_owned(), row: 1, found });
                }
                line = line.strip_prefix(UTF8_MARK).map_or(line.clone(), <[u8]>::to_vec);
            }
            if line.is_empty() {
                return Err(LogError::Empty { file: file.to_owned() });
            }
            if line.starts_with(b"#") {
                head.comment(file, &line)?;
            } else if !line.trim_ascii().is_empty() {
                head.header = line;
                return Ok((head, from));
            }
            head.lines_before += 1;
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

/// From the line counts of the CSV reader to lines of the file.
#[derive(Clone, Copy, Debug)]
pub(super) struct LineCounter {
    pub(super) before_header: u64,
    pub(super) crlf: bool,
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

/// Most bytes of what is no text that a message shows.
const MOST_SHOWN: usize = 24;

pub(super) fn utf8<'a>(file: &str, row: u64, cell: &'a [u8]) -> Result<&'a str, LogError> {
    // Zeros are text by the letter, and the mark of anything but text.
    let text = std::str::from_utf8(cell).ok().filter(|text| !text.contains('\0'));
    text.ok_or_else(|| {
        let shown = &cell[..cell.len().min(MOST_SHOWN)];
        let more = if shown.len() < cell.len() { "..." } else { "" };
        let found = format!("`{}{more}`", shown.escape_ascii());
        LogError::NotUtf8 { file: file.to_owned(), row, found }
    })
}

/// The separator that occurs most often outside quotes in the header line: `,`, `;` or tab.
pub(super) fn detect_delimiter(line: &[u8]) -> u8 {
    const DELIMITERS: [u8; 3] = [b';', b'\t', b','];
    let mut quoted = false;
    let mut counts = [0_usize; 3];
    for byte in line {
        quoted ^= *byte == b'"';
        if let Some(i) = DELIMITERS.iter().position(|d| d == byte).filter(|_| !quoted) {
            counts[i] += 1;
        }
    }
    // The last of several maxima wins: a comma, when there is no separator at all.
    (0..3).max_by_key(|&i| counts[i]).map_or(b',', |i| DELIMITERS[i])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn separators_are_found_outside_quotes() {
        assert_eq!(detect_delimiter(b"a,b"), b',');
        assert_eq!(detect_delimiter(b"\"a,b,c\";d"), b';');
        assert_eq!(detect_delimiter(b"a\tb\tc"), b'\t');
        assert_eq!(detect_delimiter(b"alone"), b',');
    }
}
