//! What is said: results on standard output, remarks on standard error.

use std::{
    borrow::Cow,
    io::{ErrorKind, IsTerminal, Write},
    sync::atomic::{AtomicBool, Ordering::Relaxed},
};

use crate::failure::Failure;

/// Whether nothing but errors is wanted on standard error.
static IS_QUIET: AtomicBool = AtomicBool::new(false);

/// From now on there are no remarks and no progress.
pub fn be_quiet() {
    IS_QUIET.store(true, Relaxed);
}

/// Whether somebody looks at standard error and wants to know how it goes.
pub fn is_watched() -> bool {
    !IS_QUIET.load(Relaxed) && std::io::stderr().is_terminal()
}

/// A result.
///
/// # Errors
///
/// When standard output takes nothing.
pub fn say(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    said(out.write_all(tame(text).as_bytes()).and_then(|()| out.flush()))
}

/// A text that a terminal shows and does not obey, whatever names of files and columns are in it.
#[must_use]
pub fn tame(text: &str) -> Cow<'_, str> {
    let is_wild = |c: char| c.is_control() && c != '\n' && c != '\t';
    if !text.contains(is_wild) {
        return Cow::Borrowed(text);
    }
    let mut tamed = String::with_capacity(text.len());
    for character in text.chars() {
        if is_wild(character) {
            tamed.extend(character.escape_default());
        } else {
            tamed.push(character);
        }
    }
    Cow::Owned(tamed)
}

/// What came of printing: a reader that has seen enough, such as `head`, is no failure.
///
/// # Errors
///
/// When nothing could be printed.
pub fn said(printed: std::io::Result<()>) -> Result<(), Failure> {
    match printed {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(Failure::output("standard output", e)),
        _ => Ok(()),
    }
}

/// What a user may want to know besides; not with `--quiet`.
pub fn remark(text: &str) {
    if !IS_QUIET.load(Relaxed) {
        complain(text);
    }
}

/// What a user has to know. Where standard error takes nothing, there is nobody to tell.
pub fn complain(text: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{text}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_stay_lines_and_nothing_is_obeyed() {
        assert_eq!(tame("a\tb\nç\u{1b}[31m\r\u{9b}"), "a\tb\nç\\u{1b}[31m\\r\\u{9b}");
    }
}
