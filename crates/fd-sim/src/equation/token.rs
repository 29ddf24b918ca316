//! Text to tokens.

use super::error::{Found, Span, SyntaxError, SyntaxProblem};

/// Names of the language that a model cannot give to anything: words of the grammar, functions,
/// `pi`, the time `t` (s), the length `dt` (s) of an integration step, and `first`, which is 1 in the
/// first integration step of a run and 0 afterwards.
pub const RESERVED: [&str; 32] = [
    "and",
    "or",
    "not",
    "if",
    "slope",
    "clamp",
    "pi",
    "t",
    "dt",
    "first",
    "sin",
    "cos",
    "tan",
    "asin",
    "acos",
    "atan",
    "sinh",
    "cosh",
    "tanh",
    "exp",
    "ln",
    "log10",
    "sqrt",
    "abs",
    "sign",
    "floor",
    "step",
    "heaviside",
    "atan2",
    "min",
    "max",
    "pow",
];

/// Whether `text` can name something in a model: a letter or underscore, then letters, digits
/// and underscores, and not one of [`RESERVED`].
///
/// ```
/// use fd_sim::equation::is_name;
///
/// assert!(is_name("J_2") && !is_name("2J") && !is_name("sin"));
/// ```
#[must_use]
pub fn is_name(text: &str) -> bool {
    let mut bytes = text.bytes();
    bytes.next().is_some_and(|b| b.is_ascii_alphabetic() || b == b'_')
        && bytes.all(is_name_byte)
        && !RESERVED.contains(&text)
}

fn is_name_byte(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_'
}

/// The first place in which `name` occurs as a whole word.
///
/// ```
/// use fd_sim::equation::locate;
///
/// assert_eq!(locate("omega_2 + omega", "omega"), Some(10..15));
/// ```
#[must_use]
pub fn locate(text: &str, name: &str) -> Option<Span> {
    let tokens = tokens(text).ok()?;
    let found = tokens
        .into_iter()
        .find(|token| token.kind == Kind::Name && &text[token.span.clone()] == name)?;
    Some(found.span)
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    Number(f64),
    Name,
    Symbol,
    End,
}

#[derive(Clone, Debug)]
pub(super) struct Token {
    pub kind: Kind,
    pub span: Span,
}

impl Token {
    pub(super) fn found(&self, text: &str) -> Found {
        match self.kind {
            Kind::End => Found::End,
            _ => Found::Token(text[self.span.clone()].to_owned()),
        }
    }
}

/// Splits a text; the last token is always [`Kind::End`].
pub(super) fn tokens(text: &str) -> Result<Vec<Token>, SyntaxError> {
    let bytes = text.as_bytes();
    let mut tokens = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let (kind, end) = match bytes[at] {
            byte if byte.is_ascii_whitespace() => {
                at += 1;
                continue;
            }
            b'0'..=b'9' | b'.' => number(text, at)?,
            byte if byte.is_ascii_alphabetic() || byte == b'_' => {
                (Kind::Name, skip(bytes, at, is_name_byte))
            }
            b'<' | b'>' | b'=' if bytes.get(at + 1) == Some(&b'=') => (Kind::Symbol, at + 2),
            b'(' | b')' | b',' | b'+' | b'-' | b'*' | b'/' | b'^' | b'<' | b'>' => {
                (Kind::Symbol, at + 1)
            }
            _ => return Err(unknown_character(text, at)),
        };
        tokens.push(Token { kind, span: at..end });
        at = end;
    }
    tokens.push(Token { kind: Kind::End, span: text.len()..text.len() });
    Ok(tokens)
}

fn skip(bytes: &[u8], from: usize, belongs: impl Fn(u8) -> bool) -> usize {
    bytes[from..]
        .iter()
        .position(|byte| !belongs(*byte))
        .map_or(bytes.len(), |length| from + length)
}

/// Digits with at most one point, then an exponent if an `e` is followed by digits.
fn number(text: &str, start: usize) -> Result<(Kind, usize), SyntaxError> {
    let bytes = text.as_bytes();
    let is_digit = |byte: u8| byte.is_ascii_digit();
    let whole = skip(bytes, start, is_digit);
    let mut end = whole;
    if bytes.get(end) == Some(&b'.') {
        end = skip(bytes, end + 1, is_digit);
    }
    if end == start + 1 && bytes[start] == b'.' {
        return Err(unknown_character(text, start));
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        let digits = end + 1 + sign;
        if bytes.get(digits).is_some_and(u8::is_ascii_digit) {
            end = skip(bytes, digits, is_digit);
        }
    }
    match text[start..end].parse::<f64>() {
        Ok(value) if value.is_finite() => Ok((Kind::Number(value), end)),
        _ => Err(SyntaxError {
            text: text.to_owned(),
            span: start..end,
            problem: SyntaxProblem::NumberTooLarge(text[start..end].to_owned()),
        }),
    }
}

fn unknown_character(text: &str, at: usize) -> SyntaxError {
    let character = text[at..].chars().next().unwrap_or_default();
    SyntaxError {
        text: text.to_owned(),
        span: at..at + character.len_utf8(),
        problem: SyntaxProblem::UnknownCharacter(character),
    }
}
