//! The commands that help texts and documentation show, for the tests of both programs.
#![allow(clippy::unwrap_used, reason = "tests of a checkout")]

use std::{
    fs,
    path::{Path, PathBuf},
};

use clap::Command;

/// A command line as it is shown, and where.
#[derive(Clone, Debug)]
pub struct Shown {
    /// File, or command whose help it is.
    pub place: String,
    /// What a shell would be given; `cargo run` is taken for the program itself.
    pub line: String,
}

/// The top of the repository.
#[must_use]
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The commands of `program` in fenced blocks of shells in README.md, CONTRIBUTING.md, docs/*.md and docs/results/*.md.
///
/// # Panics
///
/// Outside of a checkout.
#[must_use]
pub fn of_documents(program: &str) -> Vec<Shown> {
    let mut files = vec![root().join("README.md"), root().join("CONTRIBUTING.md")];
    for folder in ["docs", "docs/results"] {
        let entries = fs::read_dir(root().join(folder)).unwrap();
        let pages = entries.map(|entry| entry.unwrap().path());
        files.extend(pages.filter(|path| path.extension().is_some_and(|e| e == "md")));
    }
    files.sort();
    let mut all = Vec::new();
    for file in files {
        let name = file.strip_prefix(root()).unwrap().display().to_string();
        let text = fs::read_to_string(&file).unwrap();
        all.extend(blocks(&text).iter().flat_map(|block| of_block(program, &name, block)));
    }
    all
}

/// Blocks of a page that are meant for a shell.
fn blocks(text: &str) -> Vec<String> {
    let mut blocks = Vec::new();
    let (mut block, mut is_shell, mut is_inside) = (String::new(), false, false);
    for line in text.lines() {
        if let Some(language) = line.trim_start().strip_prefix("```") {
            if is_inside && is_shell {
                blocks.push(std::mem::take(&mut block));
            }
            is_inside = !is_inside;
            is_shell = ["sh", "bash", "console"].contains(&language.trim());
        } else if is_inside && is_shell {
            block.push_str(line);
            block.push('\n');
        }
    }
    blocks
}

/// The commands of `program` in the help text of its command `path`: lines that are indented by two.
#[must_use]
pub fn of_help(program: &str, path: &str, help: &str) -> Vec<Shown> {
    let after = help.split_once("\nExample").map_or("", |(_, after)| after);
    let lines = after.lines().skip(1).take_while(|line| !line.is_empty());
    lines.flat_map(|line| of_block(program, &format!("{program} {path} --help"), line)).collect()
}

/// How `cargo` runs a program from a checkout.
fn by_cargo(program: &str) -> &'static str {
    if program == "fdiag" { "cargo run --release" } else { "cargo run --release -p fd-lab" }
}

fn of_block(program: &str, place: &str, block: &str) -> Vec<Shown> {
    let joined = block.replace("\\\n", " ");
    let lines = joined.lines().map(|line| line.split(" #").next().unwrap_or_default().trim());
    let ours = lines.filter_map(|line| {
        let line = match line.strip_prefix(by_cargo(program)) {
            Some("") => program.to_owned(),
            Some(rest) => format!("{program} {}", rest.strip_prefix(" -- ")?),
            None => line.to_owned(),
        };
        let is_ours = line.starts_with(&format!("{program} "))
            || line == program
            || line.contains(&format!("| {program} "));
        is_ours.then_some(line)
    });
    ours.map(|line| Shown { place: place.to_owned(), line }).collect()
}

/// The words that the program would be given.
fn words(program: &str, line: &str) -> Vec<String> {
    let ours = line.rsplit_once("| ").map_or(line, |(_, ours)| ours);
    let mut words = vec![String::new()];
    let mut is_quoted = false;
    for character in ours.chars() {
        match character {
            '\'' => is_quoted = !is_quoted,
            ' ' if !is_quoted => words.push(String::new()),
            character => {
                if let Some(word) = words.last_mut() {
                    word.push(character);
                }
            }
        }
    }
    words.retain(|word| !word.is_empty());
    debug_assert_eq!(words.first().map(String::as_str), Some(program));
    // What a shell keeps for itself.
    let end = words.iter().position(|word| word == ">" || word == "<" || word == "&&");
    words.truncate(end.unwrap_or(words.len()));
    words
}

/// Help texts of a command and of those below it.
fn of_helps(program: &str, command: &Command, path: &str, all: &mut Vec<Shown>) {
    if let Some(help) = command.get_after_help() {
        all.extend(of_help(program, path, &format!("\n{help}")));
    }
    for below in command.get_subcommands() {
        of_helps(program, below, format!("{path} {}", below.get_name()).trim(), all);
    }
}

/// Whether the program takes this line of a shell.
///
/// # Errors
///
/// What the program would say of it.
pub fn parses(program: &Command, line: &str) -> Result<(), clap::Error> {
    let words = words(program.get_name(), line);
    program.clone().try_get_matches_from(words).map(|_| ())
}

/// What is wrong with the commands that documents and help texts show. At least `least` of them are there.
///
/// # Panics
///
/// Outside of a checkout.
#[must_use]
pub fn check(program: &Command, least: usize) -> Vec<String> {
    let name = program.get_name();
    let mut all = of_documents(name);
    // A loop of a shell runs over all of them.
    for shown in &mut all {
        shown.line = shown.line.replace("$form", "few-runs");
    }
    of_helps(name, program, "", &mut all);
    let mut faults: Vec<String> = all
        .iter()
        .filter_map(|shown| {
            let error = parses(program, &shown.line).err()?;
            Some(format!("{}: `{}`: {error}", shown.place, shown.line))
        })
        .collect();
    if all.len() < least {
        faults.push(format!("{} commands of {name} are shown, expected {least}", all.len()));
    }
    faults
}
