//! What can be wrong with the text of an expression, and where.

use std::{fmt, ops::Range};

use fd_model::Shown;
use thiserror::Error;

/// A range of bytes in the text of an expression.
pub type Span = Range<usize>;

/// The text is not an expression.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{problem}, in column {}\n{}", self.column(), picture(&self.text, &self.span))]
pub struct SyntaxError {
    /// The whole text.
    pub text: String,
    /// Where the problem is.
    pub span: Span,
    /// What it is.
    pub problem: SyntaxProblem,
}

/// A way in which a text fails to be an expression.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum SyntaxProblem {
    /// Something else should stand here.
    #[error("expected {expected}, found {found}")]
    Expected {
        /// What should stand here.
        expected: &'static str,
        /// What does.
        found: Found,
    },
    /// A character that is not part of the language.
    #[error("unknown character `{}`", Shown(&.0.to_string()))]
    UnknownCharacter(char),
    /// A number that cannot be represented.
    #[error("the number `{}` is too large", Shown(.0))]
    NumberTooLarge(String),
    /// A function with the wrong number of arguments.
    #[error("`{}` takes {expected} argument(s), found {found}", Shown(function))]
    Arguments {
        /// Name of the function.
        function: String,
        /// How many it takes.
        expected: usize,
        /// How many were given.
        found: usize,
    },
    /// A name of the language in the place of a name of the model.
    #[error("`{}` is a name of the language and cannot stand here", Shown(.0))]
    Reserved(String),
    /// Parentheses, calls or operators nested too deeply.
    #[error("nested more than {limit} levels deep: move a part to a definition of its own")]
    TooDeep {
        /// Deepest allowed nesting.
        limit: usize,
    },
}

/// What was found in the place of something else.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Found {
    /// The end of the text.
    End,
    /// A word or symbol.
    Token(String),
    /// A number where a condition is needed.
    Number,
    /// A condition where a number is needed.
    Condition,
}

impl fmt::Display for Found {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::End => f.write_str("the end"),
            Self::Token(token) => write!(f, "`{}`", Shown(token)),
            Self::Number => f.write_str("a number"),
            Self::Condition => f.write_str("a condition (true or false)"),
        }
    }
}

impl SyntaxError {
    /// Column of the problem, counted in characters from 1 within its line.
    #[must_use]
    pub fn column(&self) -> usize {
        column(&self.text, self.span.start)
    }
}

fn line_start(text: &str, at: usize) -> usize {
    text.get(..at).and_then(|before| before.rfind('\n')).map_or(0, |newline| newline + 1)
}

fn column(text: &str, at: usize) -> usize {
    text.get(line_start(text, at)..at).map_or(0, |before| before.chars().count()) + 1
}

/// Most characters of a line that are shown, and of those before the place that is pointed at.
const SHOWN: usize = 120;
const BEFORE: usize = 60;

/// The line of `text` that holds the start of `span`, with carets below; of a long line what is around
/// the place.
///
/// ```
/// use fd_sim::equation::picture;
///
/// assert_eq!(picture("a*(b + )", &(7..8)), "    a*(b + )\n           ^");
/// ```
#[must_use]
pub fn picture(text: &str, span: &Span) -> String {
    let start = line_start(text, span.start);
    let line = text.get(start..).and_then(|rest| rest.lines().next()).unwrap_or_default();
    let width = text
        .get(span.start..span.end.min(start + line.len()))
        .map_or(1, |marked| marked.chars().count().max(1));
    let indent = column(text, span.start) - 1;
    let from = if indent + width <= SHOWN { 0 } else { indent.saturating_sub(BEFORE) };
    let lead = if from == 0 { "" } else { "…" };
    // What takes no room or another one would shift the carets: it is shown as a blank.
    let shown = line.chars().skip(from).take(SHOWN);
    let shown: String = shown.map(|c| if c.is_control() { ' ' } else { c }).collect();
    let cut = if from + SHOWN < line.chars().count() { "…" } else { "" };
    let indent = indent - from + lead.chars().count();
    let width =
        width.min((lead.chars().count() + shown.chars().count()).saturating_sub(indent).max(1));
    format!("    {lead}{shown}{cut}\n    {}{}", " ".repeat(indent), "^".repeat(width))
}
