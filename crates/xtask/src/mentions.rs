//! What pages say of the code is there: items that they link to their file, and tests that they name.

use std::path::Path;

use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd};

use crate::{
    links::markdown_files,
    sources::{Faults, read, rust_files},
};

/// What defines an item.
const KEYWORDS: [&str; 8] = ["fn", "struct", "enum", "trait", "type", "const", "static", "mod"];

/// Checks every page of `docs`.
pub(crate) fn check(root: &Path) -> Faults {
    let mut pages = Vec::new();
    markdown_files(&root.join("docs"), &mut pages)?;
    let mut faults = Vec::new();
    for page in pages {
        let text = read(&page)?;
        let name = page.strip_prefix(root).unwrap_or(&page).display().to_string();
        let Mentions { items, tests } = mentions(&text);
        for (item, file) in items {
            let file = page.parent().unwrap_or(&page).join(file);
            // That the file is there is checked with all links.
            if file.exists() && !is_item_of(&item, &file, &read(&file)?) {
                faults.push(format!("{name}: `{item}` is not in {}", file.display()));
            }
        }
        for (package, test) in tests {
            if !has_test(&root.join("crates").join(&package), &test)? {
                faults.push(format!("{name}: {package} has no test `{test}`"));
            }
        }
    }
    Ok(faults)
}

/// What a page mentions.
#[derive(Debug, Default, PartialEq)]
struct Mentions {
    /// Paths of items, and the files that they are linked to.
    items: Vec<(String, String)>,
    /// Crates, and tests of theirs.
    tests: Vec<(String, String)>,
}

fn mentions(text: &str) -> Mentions {
    let mut found = Mentions::default();
    let mut file = None;
    for event in Parser::new_ext(text, Options::ENABLE_TABLES) {
        match event {
            Event::Start(Tag::Link { dest_url, .. }) if dest_url.ends_with(".rs") => {
                file = Some(dest_url.to_string());
            }
            Event::End(TagEnd::Link) => file = None,
            Event::Code(code) => match (&file, code.split_once(' ')) {
                (Some(file), None) if code.contains("::") => {
                    found.items.push((code.to_string(), file.clone()));
                }
                (None, Some((package, test))) if is_test(package, test) => {
                    found.tests.push((package.to_owned(), test.to_owned()));
                }
                _ => {}
            },
            _ => {}
        }
    }
    found
}

/// Whether two words are a crate and a test of it, such as `fd-ident equation_18`: of the crate `fdiag`, which is a
/// command as well, only names of several words.
fn is_test(package: &str, test: &str) -> bool {
    let is_name = !test.is_empty() && test.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    is_name && (package.starts_with("fd-") || package.starts_with("fdiag") && test.contains('_'))
}

/// Whether the file defines what the path ends with, or is that module.
fn is_item_of(path: &str, file: &Path, text: &str) -> bool {
    let item = path.rsplit("::").next().unwrap_or(path);
    let is_module = [format!("{item}.rs"), format!("{item}/mod.rs")];
    is_module.iter().any(|end| file.ends_with(end)) || defines(text, item)
}

fn defines(text: &str, item: &str) -> bool {
    let mut words = text.split(|c: char| !(c.is_alphanumeric() || c == '_')).peekable();
    while let Some(word) = words.next() {
        if KEYWORDS.contains(&word) && words.peek() == Some(&item) {
            return true;
        }
    }
    false
}

fn has_test(package: &Path, test: &str) -> Result<bool, String> {
    let mut files = Vec::new();
    rust_files(&package.join("tests"), &mut files)?;
    for file in files {
        if defines(&read(&file)?, test) {
            return Ok(true);
        }
    }
    Ok(false)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_and_tests_are_found() {
        let text = "| [`fd_a::b::C`](../crates/fd-a/src/b.rs) | `fd-a law_1` | `fdiag gap` | \
                    [`x.rs`](x.rs) `cargo test -p fd-a` |\n|---|---|---|---|\n";
        let item = ("fd_a::b::C".to_owned(), "../crates/fd-a/src/b.rs".to_owned());
        let test = ("fd-a".to_owned(), "law_1".to_owned());
        assert_eq!(mentions(text), Mentions { items: vec![item], tests: vec![test] });
        assert!(is_test("fdiag", "docs_are_true") && !is_test("fdiag", "gap"));
    }

    #[test]
    fn an_item_is_what_a_keyword_comes_before() {
        let text = "use a::Gone;\npub struct Kept<T>(T);\n";
        let file = Path::new("crates/fd-a/src/b.rs");
        assert!(is_item_of("fd_a::b::Kept", file, text) && is_item_of("fd_a::b", file, text));
        assert!(!is_item_of("fd_a::b::Gone", file, text));
        let here = Path::new(env!("CARGO_MANIFEST_DIR"));
        assert!(!has_test(here, "no_such_test").unwrap());
    }
}
