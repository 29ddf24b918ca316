//! `docs/constants.md` lists the constants of the diagnosis as they are in the source.
#![allow(clippy::unwrap_used, reason = "tests panic to fail")]

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

const ROOMS: [&str; 8] =
    ["diagnose", "evidence", "quality", "shrink", "fit", "few_runs", "reading", "road"];

/// A row of the table without its last column, which only people know: how the value was set.
fn row(file: &str, name: &str, value: &str, what: &str) -> String {
    format!("| `{file}` | `{name}` | `{value}` | {} |", what.trim())
}

/// Rust files below a directory, in order.
fn files(directory: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(directory).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path));
        } else {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// What is in a file, each with its documentation: its constants, and the defaults of its settings.
fn constants(file: &str, text: &str) -> Vec<String> {
    let text = text.split("#[cfg(test)]").next().unwrap_or_default();
    let (mut rows, mut fields, mut what) = (Vec::new(), Vec::new(), String::new());
    let mut lines = text.lines().map(str::trim);
    while let Some(line) = lines.next() {
        let restricted = || line.strip_prefix("pub(").and_then(|rest| rest.split_once(") "));
        let public = line.strip_prefix("pub ").or_else(|| restricted().map(|(_, item)| item));
        let item = public.unwrap_or(line);
        if let Some(doc) = line.strip_prefix("///") {
            what.extend([" ", doc.trim()]);
        } else if item.starts_with("const ") && !item.starts_with("const fn") {
            let mut whole = item.to_owned();
            while !whole.ends_with(';') {
                whole = format!("{whole} {}", lines.next().unwrap());
            }
            let (left, value) = whole.split_once('=').unwrap();
            let name = left["const ".len()..].split(':').next().unwrap();
            rows.push(row(file, name, value.trim_end_matches(';').trim(), &what));
        } else if let Some((name, _)) = public.and_then(|field| field.split_once(": ")) {
            fields.push((name, what.clone()));
        }
        if !line.starts_with("///") && !line.starts_with("#[") {
            what.clear();
        }
    }
    for (name, value) in defaults(text) {
        let what = fields.iter().find(|(known, _)| *known == name).unwrap();
        rows.push(row(file, name, value, &what.1));
    }
    rows
}

/// Names and values in the `Default` of a file.
fn defaults(text: &str) -> Vec<(&str, &str)> {
    let Some((_, body)) = text.split_once("fn default() -> Self {") else { return Vec::new() };
    let body = body.split_once("Self {").and_then(|(_, rest)| rest.split_once('}')).unwrap().0;
    body.split(',').filter_map(|field| field.trim().split_once(": ")).collect()
}

#[test]
fn the_table_of_constants_is_that_of_the_source() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut expected = BTreeSet::new();
    let is_source = |path: &PathBuf| path.file_name().is_some_and(|name| name != "tests.rs");
    for path in ROOMS.iter().flat_map(|room| files(&source.join(room))).filter(is_source) {
        let file = path.strip_prefix(&source).unwrap().to_str().unwrap().replace('\\', "/");
        expected.extend(constants(&file, &fs::read_to_string(&path).unwrap()));
    }
    assert!(100 < expected.len(), "only {} constants", expected.len());

    let table = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/constants.md");
    let text = fs::read_to_string(table).unwrap();
    let mut listed = BTreeSet::new();
    for line in text.lines().filter(|line| line.starts_with("| `")) {
        let (row, how) = line.trim_end_matches('|').trim_end().rsplit_once(" | ").unwrap();
        assert!(!how.trim().is_empty(), "not said how it was set: {line}");
        listed.insert(format!("{row} |"));
    }
    let missing: Vec<&String> = expected.difference(&listed).collect();
    let stale: Vec<&String> = listed.difference(&expected).collect();
    assert!(missing.is_empty() && stale.is_empty(), "missing {missing:#?}, stale {stale:#?}");
}
