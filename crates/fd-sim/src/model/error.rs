//! What can be wrong with a model, and where in its file.

use std::{collections::HashMap, fmt, ops::Range};

use fd_model::{Shown, ShownMessage};
use thiserror::Error;

use crate::equation::{Span, SyntaxProblem, TableError, locate, picture};

/// A model file cannot be loaded.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum LoadError {
    /// The file cannot be read.
    #[error("{file}: {message}")]
    Read {
        /// Path of the file.
        file: String,
        /// What the operating system says.
        message: String,
    },
    /// The file is not a correct model.
    #[error("{file}:{error}")]
    Model {
        /// Path of the file.
        file: String,
        /// What is wrong.
        error: ModelError,
    },
}

/// A model is not correct.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelError {
    /// Path to the entry, such as `states.omega.derivative`.
    pub key: String,
    /// Line and column in the file, if the model came from one.
    pub place: Option<Place>,
    /// The expression and the part of it that is wrong, if the mistake is in an expression.
    pub expression: Option<Box<(String, Span)>>,
    /// What is wrong.
    pub mistake: Box<Mistake>,
    /// What is wrong besides, in the order of the file.
    pub others: Vec<ModelError>,
}

/// A place in a file, counted from 1, in characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Line.
    pub line: usize,
    /// Column.
    pub column: usize,
}

/// A way in which a model is not correct.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Mistake {
    /// The text is not TOML or does not have the form of a model.
    #[error("{}", ShownMessage(.0))]
    Toml(String),
    /// Another version of the format.
    #[error("this is format version {found}, this program reads version 1")]
    Version {
        /// Version of the file.
        found: u32,
    },
    /// Another kind of model.
    #[error("this is a model of kind `{}`, expected `equations`", Shown(found))]
    Kind {
        /// Kind of the file.
        found: String,
    },
    /// Not an expression.
    #[error(transparent)]
    Syntax(SyntaxProblem),
    /// A name that is not defined, or not here.
    #[error("`{}` is not known here{}", Shown(name), hint(.nearest))]
    UnknownName {
        /// The name.
        name: String,
        /// What may have been meant.
        nearest: Vec<String>,
    },
    /// A name that means something but not in this place.
    #[error("`{}` is {what} and cannot be used here, only {allowed}", Shown(name))]
    NotHere {
        /// The name.
        name: String,
        /// What it is.
        what: &'static str,
        /// What may be used here.
        allowed: &'static str,
    },
    /// A function or table that does not exist.
    #[error("there is no function or table `{}`{}", Shown(name), hint(.nearest))]
    UnknownFunction {
        /// The name.
        name: String,
        /// What may have been meant.
        nearest: Vec<String>,
    },
    /// A name that cannot be given.
    #[error(
        "`{}` cannot be a name: at most 256 letters, digits and underscores, not a word of the language",
        Shown(.0)
    )]
    BadName(String),
    /// A name given twice.
    #[error("the name `{}` is already given to {}", Shown(name), Shown(first))]
    Duplicate {
        /// The name.
        name: String,
        /// Key of the first one.
        first: String,
    },
    /// Expressions that need themselves.
    #[error("definitions go round in a circle: {}", round(.0))]
    Cycle(Vec<String>),
    /// A name or unit that a terminal or a page would not show as it is.
    #[error("expected text without line breaks and control characters, found `{}`", Shown(.0))]
    NotPlain(String),
    /// No unit.
    #[error("a unit is needed, `1` for a pure number")]
    NoUnit,
    /// What wraps is no angle.
    #[error("`wraps = true` is for angles: expected a unit of angles (`rad`, `deg`, `rev`), found `{}`", Shown(.0))]
    NoAngle(String),
    /// A number out of its range.
    #[error("{what} must be {expected}, got {found}")]
    Number {
        /// What the number is.
        what: &'static str,
        /// What it must be.
        expected: &'static str,
        /// What it is.
        found: f64,
    },
    /// Neither or both of two entries.
    #[error("exactly one of `derivative` and `update` is needed")]
    Law,
    /// A law that this state cannot have.
    #[error("{0}")]
    WrongLaw(&'static str),
    /// The points do not make a table.
    #[error(transparent)]
    Table(#[from] TableError),
    /// Something of which there must be at least one.
    #[error("at least one of `{0}` is needed")]
    Empty(&'static str),
    /// An expression that was built deeper than it could be read back.
    #[error("the expression is nested deeper than {limit} levels")]
    TooDeep {
        /// Deepest allowed nesting.
        limit: usize,
    },
}

/// The way round; of a long one the beginning and the end.
fn round(path: &[String]) -> String {
    const SHOWN: usize = 10;
    let shown = |part: &[String]| {
        part.iter().map(|name| Shown(name).to_string()).collect::<Vec<_>>().join(" → ")
    };
    match path.len() {
        0..=SHOWN => shown(path),
        n => format!("{} → … ({n} in all) → {}", shown(&path[..SHOWN - 1]), shown(&path[n - 1..])),
    }
}

fn hint(nearest: &[String]) -> String {
    match nearest {
        [] => String::new(),
        names => format!("; did you mean `{}`?", names.join("` or `")),
    }
}

/// Where the values of a file are, by key.
pub(super) type Places = HashMap<String, Range<usize>>;

impl ModelError {
    pub(crate) fn new(key: impl Into<String>, mistake: Mistake) -> Self {
        let (key, mistake) = (key.into(), Box::new(mistake));
        Self { key, place: None, expression: None, mistake, others: Vec::new() }
    }

    /// All of them as one; nothing is wrong where there is none.
    pub(super) fn all(errors: Vec<Self>) -> Result<(), Self> {
        let mut errors = errors.into_iter();
        errors.next().map_or(Ok(()), |first| Err(Self { others: errors.collect(), ..first }))
    }

    pub(super) fn in_expression(mut self, text: String, span: Span) -> Self {
        self.expression = Some(Box::new((text, span)));
        self
    }

    /// Adds line and column. A mistake inside an expression is pointed at where the expression
    /// stands in the file, as it is written there; with escapes in it, its beginning is.
    pub(super) fn found_in(mut self, places: &Places, file: &str) -> Self {
        let others = std::mem::take(&mut self.others).into_iter();
        self.others = others.map(|other| other.found_in(places, file)).collect();
        let Some(range) = nearest_key(places, &self.key) else { return self };
        let mut at = range.start;
        if let Some((text, span)) = self.expression.as_deref_mut() {
            let raw = file.get(range).unwrap_or_default();
            let written = raw.trim_matches(['"', '\'']);
            let start = at + (raw.len() - raw.trim_start_matches(['"', '\'']).len());
            if written == text {
                at = start + span.start;
            } else if let Some(place) = locate(written, &text[span.clone()]) {
                // Spaces were written in another way than they are printed.
                at = start + place.start;
                (*text, *span) = (written.to_owned(), place);
            }
        }
        self.place = Some(Place::of(file, at));
        self
    }
}

/// The place of the entry, or of the closest entry around it.
fn nearest_key(places: &Places, key: &str) -> Option<Range<usize>> {
    let mut key = key;
    loop {
        if let Some(range) = places.get(key) {
            return Some(range.clone());
        }
        key = key.rsplit_once('.')?.0;
    }
}

impl Place {
    pub(super) fn of(file: &str, at: usize) -> Self {
        let before = file.get(..at).unwrap_or(file);
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        Self {
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
        }
    }
}

impl fmt::Display for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(Place { line, column }) = self.place {
            write!(f, "{line}:{column}: ")?;
        }
        if !self.key.is_empty() {
            write!(f, "{}: ", Shown(&self.key))?;
        }
        write!(f, "{}", self.mistake)?;
        if let Some((text, span)) = self.expression.as_deref() {
            write!(f, "\n{}", picture(text, span))?;
        }
        self.others.iter().try_for_each(|other| write!(f, "\n{other}"))
    }
}

impl std::error::Error for ModelError {}
