//! What stands before the rows of a log, and where in the file each row is.

use std::io::{self, BufRead, BufReader, Read};

use fd_model::file::FileAction;

use crate::error::LogError;

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
            from.read_until(b'\n', &mut line).map_err(|error| cannot_read(file, error.kind()))?;
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

pub(super) fn cannot_read(file: &str, kind: io::ErrorKind) -> LogError {
    LogError::Io { file: file.to_owned(), action: FileAction::Read, kind }
}
