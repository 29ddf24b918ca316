//! The commands that help texts and documentation show.

use std::{
    fs,
    path::{Path, PathBuf},
};

/// A command line as it is shown, and where.
#[derive(Clone, Debug)]
pub(crate) struct Shown {
    pub(crate) place: String,
    /// What a shell would be given; `cargo run` is taken for the program itself.
    pub(crate) line: String,
}

/// The top of the repository.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The commands in fenced blocks of shells in README.md, docs/*.md and docs/results/*.md.
pub(crate) fn of_documents() -> Vec<Shown> {
    let mut files = vec![root().join("README.md")];
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
        all.extend(blocks(&text).iter().flat_map(|block| of_block(&name, block)));
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

/// The commands of a help text: lines that are indented by two.
pub(crate) fn of_help(command: &str, help: &str) -> Vec<Shown> {
    let after = help.split_once("\nExample").map_or("", |(_, after)| after);
    let lines = after.lines().skip(1).take_while(|line| !line.is_empty());
    lines.flat_map(|line| of_block(&format!("fdiag {command} --help"), line)).collect()
}

fn of_block(place: &str, block: &str) -> Vec<Shown> {
    let joined = block.replace("\\\n", " ");
    let lines = joined.lines().map(|line| line.split(" #").next().unwrap_or_default().trim());
    let ours = lines.filter_map(|line| {
        let line = match line.strip_prefix("cargo run --release") {
            Some("") => "fdiag".to_owned(),
            Some(rest) => format!("fdiag {}", rest.strip_prefix(" -- ")?),
            None => line.to_owned(),
        };
        let is_ours = line.starts_with("fdiag ") || line == "fdiag" || line.contains("| fdiag ");
        is_ours.then_some(line)
    });
    ours.map(|line| Shown { place: place.to_owned(), line }).collect()
}
