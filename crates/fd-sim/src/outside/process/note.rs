//! What a program tells the user while it runs: lines on its standard error.

use std::sync::{Arc, OnceLock};

/// What such a line begins with; and one that is only to be told if the program ends before the next of its kind.
const TOLD: &str = "fdiag: note: ";
const IN_CASE: &str = "fdiag: note in case of an end: ";
/// What is kept of a line, in bytes.
const LONGEST: usize = 1024;

/// The first note of any of the running programs.
#[derive(Clone, Debug, Default)]
pub(super) struct Note(Arc<OnceLock<String>>);

/// What was found out about a program is not what it is.
impl PartialEq for Note {
    fn eq(&self, _other: &Self) -> bool {
        true
    }
}

impl Note {
    pub(super) fn get(&self) -> Option<String> {
        self.0.get().cloned()
    }
}

/// Whether a line is none of the last words.
pub(super) fn is_note(line: &str) -> bool {
    line.starts_with(TOLD) || line.starts_with(IN_CASE)
}

/// Finds notes in what comes in pieces; when it is dropped, the program has ended.
#[derive(Debug)]
pub(super) struct Lines {
    note: Note,
    line: Vec<u8>,
    in_case: String,
}

impl Lines {
    pub(super) fn new(note: Note) -> Self {
        Self { note, line: Vec::new(), in_case: String::new() }
    }

    pub(super) fn take(&mut self, bytes: &[u8]) {
        for byte in bytes {
            match byte {
                b'\n' => self.end_line(),
                _ if self.line.len() < LONGEST => self.line.push(*byte),
                _ => {}
            }
        }
    }

    fn end_line(&mut self) {
        let line = String::from_utf8_lossy(&self.line);
        if let Some(told) = line.strip_prefix(TOLD) {
            self.note.0.get_or_init(|| told.trim().to_owned());
        } else if let Some(in_case) = line.strip_prefix(IN_CASE) {
            in_case.trim().clone_into(&mut self.in_case);
        }
        self.line.clear();
    }
}

impl Drop for Lines {
    fn drop(&mut self) {
        if !self.in_case.is_empty() {
            self.note.0.get_or_init(|| std::mem::take(&mut self.in_case));
        }
    }
}

/// Tells the user of this simulator something.
#[cfg(feature = "fmu")]
pub(in super::super) fn tell(note: &str) {
    write(TOLD, note);
}

/// Tells it only if this process ends before that is said again; nothing is told any more of an empty text.
#[cfg(feature = "fmu")]
pub(in super::super) fn tell_in_case_of_an_end(note: &str) {
    write(IN_CASE, note);
}

#[cfg(feature = "fmu")]
fn write(prefix: &str, note: &str) {
    use std::io::Write as _;
    // Where nobody listens, nobody has to know.
    let _ = std::io::stderr().write_all(format!("{prefix}{note}\n").as_bytes());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_found_in_pieces_and_the_first_counts() {
        let note = Note::default();
        let mut lines = Lines::new(note.clone());
        lines.take(b"loading\nfdiag: no");
        lines.take(b"te: not to be trusted");
        assert_eq!(note.get(), None);
        lines.take(b" \nfdiag: note: later\n");
        assert_eq!(note.get().as_deref(), Some("not to be trusted"));
    }

    #[test]
    fn what_is_for_an_end_is_told_at_an_end() {
        let note = Note::default();
        let mut lines = Lines::new(note.clone());
        lines.take(b"fdiag: note in case of an end: it was old\nfdiag: note in case of an end: \n");
        drop(lines);
        assert_eq!(note.get(), None);
        let mut lines = Lines::new(note.clone());
        lines.take(b"fdiag: note in case of an end: it was old\nout of memory\n");
        drop(lines);
        assert_eq!(note.get().as_deref(), Some("it was old"));
    }
}
