//! `docs/unsafe.md` is whole: a row for each `unsafe` of the workspace, and the versions of `Cargo.lock`.

use std::{collections::BTreeMap, path::Path};

use crate::sources::{Faults, read, rust_files};

/// The page.
const PAGE: &str = "docs/unsafe.md";

/// What comes behind the keyword where it is more than a type of a function. Split, so that this file passes its own check.
const BEHIND: [&str; 5] = [" {", " fn ", " impl", " trait", " extern \"C\" {"];
const KEYWORD: &str = concat!("un", "safe");

/// Compares the page with the sources and the lock file below `root`.
pub(crate) fn check(root: &Path) -> Faults {
    let page = read(&root.join(PAGE))?;
    let (mut listed, mut faults) = (rows(&page), Vec::new());
    let mut files = Vec::new();
    for directory in ["crates", "benches", "examples", "fuzz"] {
        rust_files(&root.join(directory), &mut files)?;
    }
    for path in files {
        let name = path.strip_prefix(root).unwrap_or(&path).display().to_string();
        let (found, rows) = (uses(&read(&path)?), listed.remove(&name).unwrap_or(0));
        if found != rows {
            faults.push(format!("{name}: {KEYWORD} {found} times, {PAGE} has {rows} rows for it"));
        }
    }
    let gone = |name: &String| format!("{PAGE}: there is no file {name}");
    faults.extend(listed.keys().map(gone));
    faults.extend(old_versions(&page, &read(&root.join("Cargo.lock"))?)?);
    Ok(faults)
}

/// How often a file says it, comments and types of functions left out.
fn uses(text: &str) -> usize {
    let code = text.lines().map(|line| line.split("//").next().unwrap_or_default());
    code.map(|line| line.split(KEYWORD).skip(1).filter(|rest| is_use(rest)).count()).sum()
}

fn is_use(rest: &str) -> bool {
    BEHIND.iter().any(|behind| rest.starts_with(behind))
}

/// Rows of the tables under headings that are files.
fn rows(page: &str) -> BTreeMap<String, usize> {
    let sections = page.split("\n#").skip(1).filter_map(|section| {
        let (heading, body) = section.split_once('\n')?;
        let file = heading.trim_start_matches('#').trim().strip_prefix('`')?.strip_suffix('`')?;
        Some((file.to_owned(), body.lines().filter(|line| line.starts_with('|')).count()))
    });
    // Two lines of each are its head.
    sections.map(|(file, lines)| (file, lines.saturating_sub(2))).collect()
}

/// Crates whose version on the page is not one of those that are locked.
fn old_versions(page: &str, lock: &str) -> Faults {
    let lock: toml::Table = lock.parse().map_err(|e: toml::de::Error| e.to_string())?;
    let packages = lock.get("package").and_then(toml::Value::as_array).ok_or("no packages")?;
    let text = |package: &toml::Value, key: &str| {
        package.get(key).and_then(toml::Value::as_str).unwrap_or_default().to_owned()
    };
    let mut locked: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for package in packages {
        locked.entry(text(package, "name")).or_default().push(text(package, "version"));
    }
    let stated = page.lines().filter_map(|line| {
        let mut cells = line.strip_prefix('|')?.split('|').map(str::trim);
        let name = cells.next()?.strip_prefix('`')?.strip_suffix('`')?;
        let version = cells.next().filter(|v| v.starts_with(|c: char| c.is_ascii_digit()))?;
        Some((name, version))
    });
    let none = Vec::new();
    let faults = stated.filter_map(|(name, version)| {
        let locked = locked.get(name).unwrap_or(&none);
        let is_locked = locked.iter().any(|locked| locked == version);
        let found = locked.join(", ");
        (!is_locked).then(|| format!("{PAGE}: {name} {version}, Cargo.lock has `{found}`"))
    });
    Ok(faults.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uses_are_counted() {
        let text = "type F = un_safe extern \"C\" fn(u8);\nun_safe fn f() {}\nlet x = un_safe { f() };\n\
                    // un_safe { }\nun_safe impl Send for X {}\nconst P: &str = \"'un_safe-inline'\";\n";
        assert_eq!(uses(&text.replace("un_safe", KEYWORD)), 3);
    }

    #[test]
    fn rows_and_versions_are_compared() {
        let page = "# Page\n\n### `a/b.rs`\n\n| what | why |\n|---|---|\n| x | y |\n| z | w |\n\n## Rest\n\n\
                    | crate | version |\n|---|---|\n| `csv` | 1.4.0 |\n| `toml` | 0.9.0 |\n";
        assert_eq!(rows(page).into_iter().collect::<Vec<_>>(), [("a/b.rs".to_owned(), 2)]);
        let lock = "[[package]]\nname = \"csv\"\nversion = \"1.4.0\"\n\
                    [[package]]\nname = \"toml\"\nversion = \"1.2.1\"\n";
        let faults = old_versions(page, lock).unwrap();
        assert_eq!(faults, ["docs/unsafe.md: toml 0.9.0, Cargo.lock has `1.2.1`"]);
    }
}
