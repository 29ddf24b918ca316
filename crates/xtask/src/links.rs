//! Links between pages lead somewhere: files that are there, and headings that are there.

use std::{
    fs,
    path::{Path, PathBuf},
};

use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd};

use crate::sources::{Faults, read};

/// Folders whose pages are not ours.
const LEFT_OUT: [&str; 3] = ["target", ".git", "node_modules"];

/// Checks every relative link of every Markdown page below `root`.
pub(crate) fn check(root: &Path) -> Faults {
    let mut pages = Vec::new();
    markdown_files(root, &mut pages)?;
    let mut faults = Vec::new();
    for page in pages {
        let text = read(&page)?;
        let name = page.strip_prefix(root).unwrap_or(&page).display().to_string();
        for link in links(&text) {
            if let Some(fault) = fault(&page, &link)? {
                faults.push(format!("{name}: {fault}"));
            }
        }
    }
    Ok(faults)
}

/// What is wrong with a link, if anything is.
fn fault(page: &Path, link: &str) -> Result<Option<String>, String> {
    let is_external = link.contains("://") || link.starts_with("mailto:");
    if is_external {
        return Ok(None);
    }
    let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
    let target =
        if file.is_empty() { page.to_owned() } else { page.parent().unwrap_or(page).join(file) };
    if !target.exists() {
        return Ok(Some(format!("`{link}` leads to a file that is not there")));
    }
    let is_page = target.extension().is_some_and(|extension| extension == "md");
    if anchor.is_empty() || !is_page || anchors(&read(&target)?).iter().any(|a| a == anchor) {
        return Ok(None);
    }
    Ok(Some(format!("`{link}` leads to a heading that is not there")))
}

fn links(text: &str) -> Vec<String> {
    let events = Parser::new_ext(text, Options::ENABLE_TABLES);
    events
        .filter_map(|event| match event {
            Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                Some(dest_url.to_string())
            }
            _ => None,
        })
        .collect()
}

/// Anchors of all headings, as GitHub and mdBook make them.
fn anchors(text: &str) -> Vec<String> {
    let mut anchors: Vec<String> = Vec::new();
    let mut heading: Option<String> = None;
    for event in Parser::new_ext(text, Options::ENABLE_TABLES) {
        match event {
            Event::Start(Tag::Heading { .. }) => heading = Some(String::new()),
            Event::End(TagEnd::Heading(_)) => anchors.extend(heading.take().map(|h| slug(&h))),
            Event::Text(words) | Event::Code(words) => {
                if let Some(heading) = &mut heading {
                    heading.push_str(&words);
                }
            }
            _ => {}
        }
    }
    anchors
}

fn slug(heading: &str) -> String {
    let kept = |c: char| c.is_alphanumeric() || c == '-' || c == '_' || c == ' ';
    let lower = heading.trim().to_lowercase();
    lower.chars().filter(|c| kept(*c)).map(|c| if c == ' ' { '-' } else { c }).collect()
}

pub(crate) fn markdown_files(directory: &Path, files: &mut Vec<PathBuf>) -> Result<(), String> {
    let entries = fs::read_dir(directory).map_err(|e| format!("{}: {e}", directory.display()))?;
    for entry in entries {
        let path = entry.map_err(|e| e.to_string())?.path();
        let is_left_out = LEFT_OUT.iter().any(|name| path.ends_with(name));
        if path.is_dir() && !is_left_out {
            markdown_files(&path, files)?;
        } else if path.extension().is_some_and(|extension| extension == "md") {
            files.push(path);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_and_anchors_are_found() {
        let text =
            "# A *bold* `word`: yes\n[a](b.md#c) and ![p](p.svg)\n\n| t |\n|---|\n| [x](y) |\n";
        assert_eq!(links(text), ["b.md#c", "p.svg", "y"]);
        assert_eq!(anchors(text), ["a-bold-word-yes"]);
    }

    #[test]
    fn a_link_to_nowhere_is_a_fault() {
        let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../README.md");
        assert_eq!(fault(&here, "LICENSE-MIT").unwrap(), None);
        assert_eq!(fault(&here, "https://example.org/x#y").unwrap(), None);
        assert!(fault(&here, "LICENSE-MIX").unwrap().unwrap().contains("not there"));
        assert!(fault(&here, "#no-such-heading").unwrap().unwrap().contains("heading"));
    }
}
