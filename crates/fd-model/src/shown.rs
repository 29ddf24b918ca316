//! Text of a user as a message shows it: short, and without what a terminal would obey.

use std::fmt::{self, Write};

/// Most characters of a name, a cell or another piece of text.
const PIECE: usize = 120;
/// Characters at the end of a piece that was cut.
const TAIL: usize = 20;
/// Most entries of a list.
const ENTRIES: usize = 20;
/// Most characters of a line, and most lines, of a whole message.
const LINE: usize = 1000;
const LINES: usize = 60;

/// A piece of text in one line: control characters are escaped, and of more than 120 characters the
/// beginning, the end and their number are shown.
///
/// ```
/// use fd_model::Shown;
///
/// assert_eq!(Shown("T_7").to_string(), "T_7");
/// assert_eq!(Shown("a\nb\u{1b}[31m").to_string(), "a\\nb\\u{1b}[31m");
/// let long = Shown(&"x".repeat(1_000_000)).to_string();
/// assert!(long.len() < 150 && long.ends_with("xxx (1000000 characters)"));
/// assert!(Shown(&"word ".repeat(99)).to_string().ends_with("word word…word word word  (495 characters)"));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Shown<'a>(pub &'a str);

impl fmt::Display for Shown<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        cut(f, self.0, PIECE)
    }
}

/// A list in brackets, each entry in quotes; of more than twenty entries the first and their number.
///
/// ```
/// use fd_model::ShownList;
///
/// assert_eq!(ShownList(&["t", "y"]).to_string(), r#"["t", "y"]"#);
/// assert!(ShownList(&["u"; 400]).to_string().ends_with(r#""u", … (400 in all)]"#));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ShownList<'a, S>(pub &'a [S]);

impl<S: AsRef<str>> fmt::Display for ShownList<'_, S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_char('[')?;
        for (i, entry) in self.0.iter().take(ENTRIES).enumerate() {
            let separator = if i == 0 { "" } else { ", " };
            write!(f, "{separator}\"{}\"", Shown(entry.as_ref()))?;
        }
        if ENTRIES < self.0.len() {
            write!(f, ", … ({} in all)", self.0.len())?;
        }
        f.write_char(']')
    }
}

/// A whole message: its lines stay lines, other control characters are escaped, long lines and long
/// messages are cut.
///
/// ```
/// use fd_model::ShownMessage;
///
/// assert_eq!(ShownMessage("wrong:\n  x\u{7}").to_string(), "wrong:\n  x\\u{7}");
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ShownMessage<'a>(pub &'a str);

impl fmt::Display for ShownMessage<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, line) in self.0.lines().take(LINES).enumerate() {
            if 0 < i {
                f.write_char('\n')?;
            }
            cut(f, line, LINE)?;
        }
        let lines = self.0.lines().count();
        if LINES < lines { write!(f, "\n… ({lines} lines)") } else { Ok(()) }
    }
}

fn cut(f: &mut fmt::Formatter<'_>, text: &str, most: usize) -> fmt::Result {
    // Not longer in bytes is not longer in characters.
    let length = if text.len() <= most { text.len() } else { text.chars().count() };
    if length <= most {
        return escaped(f, text.chars());
    }
    // Between words, unless a word is as long as what is shown of the text.
    let at = |n: usize| text.char_indices().nth(n).map_or(text.len(), |(at, _)| at);
    let (head, tail) = (&text[..at(most - TAIL)], &text[at(length - TAIL)..]);
    let head = head.rsplit_once(' ').map_or(head, |(words, _)| words);
    let tail = tail.split_once(' ').map_or(tail, |(_, words)| words);
    escaped(f, head.chars())?;
    f.write_str("…")?;
    escaped(f, tail.chars())?;
    write!(f, " ({length} characters)")
}

fn escaped(f: &mut fmt::Formatter<'_>, characters: impl Iterator<Item = char>) -> fmt::Result {
    for character in characters {
        if is_obeyed(character) {
            write!(f, "{}", character.escape_default())?;
        } else {
            f.write_char(character)?;
        }
    }
    Ok(())
}

/// Control characters, and what turns the direction of writing round or breaks a line.
fn is_obeyed(character: char) -> bool {
    let turns = matches!(character, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    character.is_control() || turns || matches!(character, '\u{2028}' | '\u{2029}')
}

/// Whether a text can stand in one line of a report: nothing in it is obeyed instead of shown.
///
/// ```
/// assert!(fd_model::is_plain("N m/rad²") && !fd_model::is_plain("N\u{1b}[2J"));
/// ```
#[must_use]
pub fn is_plain(text: &str) -> bool {
    !text.chars().any(is_obeyed)
}
