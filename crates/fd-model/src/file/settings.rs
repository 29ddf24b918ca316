//! Settings from TOML, with errors that name file, line and key.

use std::path::Path;

use fd_core::Limits;
use serde::{Serialize, de::DeserializeOwned};
use thiserror::Error;
use toml::{Table, Value};

use super::text::read_text;
use crate::shown::{Shown, ShownMessage};

/// A file of settings cannot be read.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{}{}{}{}", Shown(file), in_line(*.line), at_key(.key), ShownMessage(message))]
pub struct SettingsError {
    /// Name of the file.
    pub file: String,
    /// Line of the file, from 1, where it is known.
    pub line: Option<usize>,
    /// Path of the key that is wrong, such as `detector.window`; empty where no single one is.
    pub key: String,
    /// What is wrong.
    pub message: String,
}

fn in_line(line: Option<usize>) -> String {
    line.map_or_else(String::new, |line| format!(", line {line}"))
}

fn at_key(key: &str) -> String {
    if key.is_empty() { ": ".to_owned() } else { format!(": `{}`: ", Shown(key)) }
}

/// Reads settings from a file.
///
/// # Errors
///
/// Returns an error that names the file, and line and key where there is one to blame.
pub fn read_settings<T: DeserializeOwned>(path: &Path) -> Result<T, SettingsError> {
    let file = path.display().to_string();
    let text = read_text(path, Limits::default().bytes).map_err(|error| {
        let message = error.to_string();
        SettingsError { file: file.clone(), line: None, key: String::new(), message }
    })?;
    parse_settings(&file, &text)
}

/// Reads settings from text; `file` is the name for errors.
///
/// ```
/// use fd_model::{ResamplePolicy, file::parse_settings};
///
/// let error = parse_settings::<ResamplePolicy>("a.toml", "tolerance = 0.1\nmax_gap_s = 'long'\n");
/// let words = "a.toml, line 2: `max_gap_s`: invalid type: string \"long\", expected f64";
/// assert_eq!(error.map_err(|e| e.to_string()), Err(words.to_owned()));
/// ```
///
/// # Errors
///
/// As [`read_settings`].
pub fn parse_settings<T: DeserializeOwned>(file: &str, text: &str) -> Result<T, SettingsError> {
    toml::from_str(text)
        .map_err(|error| refuse(file, text, &error, &|text| toml::from_str::<T>(text).is_ok()))
}

/// Settings as TOML.
///
/// They become a table before they become text: `toml::to_string` alone compiles each type in them three times, which was
/// a tenth of what compiling the library `fdiag` takes (CPU: 53.5 s, 48.8 without).
///
/// # Errors
///
/// None for settings that were read.
pub fn write_settings<T: Serialize>(settings: &T) -> Result<String, toml::ser::Error> {
    text(&Table::try_from(settings)?)
}

fn text(table: &Table) -> Result<String, toml::ser::Error> {
    toml::to_string(table)
}

/// Says what is wrong; `is_fine` tells of other texts whether they are right.
fn refuse(
    file: &str,
    text: &str,
    error: &toml::de::Error,
    is_fine: &dyn Fn(&str) -> bool,
) -> SettingsError {
    let blamed = text.parse::<Table>().ok().and_then(|table| to_blame(&table, is_fine));
    let line = error.span().map(|span| line_of(text, span.start));
    let key = blamed.unwrap_or_default();
    // Errors inside a table with a `kind` are placed at the head of the table.
    let exact = key.rsplit('.').next().and_then(|key| {
        let is_it = |line: &&str| {
            let rest = line.trim_start().strip_prefix(key);
            rest.is_some_and(|rest| rest.trim_start().starts_with('='))
        };
        let from = line.unwrap_or(1) - 1;
        let found = text.lines().skip(from).position(|line| is_it(&line))?;
        Some(from + found + 1)
    });
    let message = error.message().to_owned();
    SettingsError { file: file.to_owned(), line: exact.or(line), key, message }
}

fn line_of(text: &str, at: usize) -> usize {
    text.get(..at).map_or(1, |before| before.matches('\n').count() + 1)
}

/// The path of the one value that is wrong: with another one, or without it, all is well. `serde` does
/// not know it inside of tables whose `kind` is read first. Tables are tried as text, so that types are read in one way only,
/// which halves what is compiled.
fn to_blame(whole: &Table, is_fine: &dyn Fn(&str) -> bool) -> Option<String> {
    let others = [
        None,
        Some(Value::Integer(1)),
        Some(Value::Float(0.5)),
        Some(Value::Boolean(true)),
        Some(Value::Array(Vec::new())),
        Some(Value::Array(vec![Value::Float(0.5)])),
    ];
    let cures = |path: &Vec<&str>| {
        others.iter().any(|other| {
            let mut changed = whole.clone();
            change(&mut changed, path, other.clone());
            text(&changed).is_ok_and(|text| is_fine(&text))
        })
    };
    leaves(whole).into_iter().find(cures).map(|path| path.join("."))
}

/// Paths of all values that are no tables, at most so many: blame is not worth more.
fn leaves(table: &Table) -> Vec<Vec<&str>> {
    const MOST: usize = 500;
    let mut found = Vec::new();
    let mut open: Vec<(Vec<&str>, &Table)> = vec![(Vec::new(), table)];
    while let Some((path, table)) = open.pop() {
        for (key, value) in table {
            let mut path = path.clone();
            path.push(key);
            match value {
                Value::Table(inner) => open.push((path, inner)),
                _ if found.len() < MOST => found.push(path),
                _ => return found,
            }
        }
    }
    found
}

/// Puts another value, or none, in the place of one.
fn change(table: &mut Table, path: &[&str], other: Option<Value>) {
    match (path, other) {
        ([], _) => {}
        ([key], None) => {
            table.remove(*key);
        }
        ([key], Some(other)) => {
            table.insert((*key).to_owned(), other);
        }
        ([key, rest @ ..], other) => {
            if let Some(Value::Table(inner)) = table.get_mut(*key) {
                change(inner, rest, other);
            }
        }
    }
}
