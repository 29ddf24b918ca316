//! Rules for source files: short, introduced by a sentence, finished, and free of local paths.

use std::{
    fs,
    path::{Path, PathBuf},
};

/// What a check returns: the faults it found, or why it could not run.
pub(crate) type Faults = Result<Vec<String>, String>;

/// Longest allowed source file, in lines: a longer one is asking to be two.
const MAX_LINES: usize = 400;

/// Text that has no place in a source file, and why. Split so that this file passes its own check.
const BANNED: [(&str, &str); 4] = [
    (concat!("todo", "!("), "unfinished work"),
    (concat!("unimplemented", "!("), "unfinished work"),
    (concat!("println!(\"ski", "pped"), "a test that passes without asserting"),
    (concat!("\"/wo", "rk/"), "a path of one machine"),
];

/// How a test is left out of a plain run, with or without a condition.
const IGNORED: [&str; 2] = [concat!("#[ig", "nore"), concat!("#[cfg", "_attr")];

/// The reasons for it: what a clone does not bring. `.ci/run` runs these tests where it is there.
const NEEDS: [&str; 5] = [
    "needs chromium",
    "needs mosquitto",
    "needs nginx",
    "needs the logs of ../shared/data",
    "needs valgrind",
];

/// Checks every Rust file below `root` that git would track.
pub(crate) fn check(root: &Path) -> Faults {
    let mut files = Vec::new();
    for directory in ["crates", "benches", "examples", "fuzz"] {
        rust_files(&root.join(directory), &mut files)?;
    }
    let mut faults = Vec::new();
    for path in files {
        let text = read(&path)?;
        let name = path.strip_prefix(root).unwrap_or(&path).display().to_string();
        faults.extend(check_text(&text).into_iter().map(|fault| format!("{name}: {fault}")));
    }
    Ok(faults)
}

/// The text of a file; the message of one that cannot be read names it.
pub(crate) fn read(path: &Path) -> Result<String, String> {
    fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))
}

fn check_text(text: &str) -> Vec<String> {
    let mut faults = Vec::new();
    let lines = text.lines().count();
    if lines > MAX_LINES {
        faults.push(format!("{lines} lines, at most {MAX_LINES}"));
    }
    if !text.starts_with("//! ") {
        faults.push("the first line must say what the file is about (`//! …`)".to_owned());
    }
    let banned = BANNED.iter().filter(|(found, _)| text.contains(found));
    faults.extend(banned.map(|(found, why)| format!("`{found}`: {why}")));
    faults.extend(ignored_without_need(text));
    faults
}

/// Ignored tests whose reason is not one of [`NEEDS`].
fn ignored_without_need(text: &str) -> Vec<String> {
    let [plain, conditional] = IGNORED;
    let is_needed =
        |rest: &str| NEEDS.iter().any(|need| rest.starts_with(&format!(" = \"{need}\"]")));
    let is_conditional =
        |rest: &str| rest.split(")]").next().is_some_and(|inside| inside.contains("ignore"));
    let without = text.split(plain).skip(1).filter(|rest| !is_needed(rest));
    let under_condition = text.split(conditional).skip(1).filter(|rest| is_conditional(rest));
    let reasons = NEEDS.join("`, `");
    without
        .chain(under_condition)
        .map(|_| format!("a test that does not run; the only reasons are: `{reasons}`"))
        .collect()
}

/// All Rust files below a directory, those of builds left out.
pub(crate) fn rust_files(directory: &Path, files: &mut Vec<PathBuf>) -> Result<(), String> {
    let Ok(entries) = fs::read_dir(directory) else { return Ok(()) };
    for entry in entries {
        let path = entry.map_err(|e| format!("{}: {e}", directory.display()))?.path();
        if path.is_dir() && !path.ends_with("target") {
            rust_files(&path, files)?;
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_good_file_has_no_faults() {
        assert!(check_text("//! What it is.\nfn f() {}\n").is_empty());
    }

    #[test]
    fn every_rule_bites() {
        let long = format!("fn f() {{}}\n{}", "// x\n".repeat(MAX_LINES));
        assert_eq!(check_text(&long).len(), 2);
        for (text, _) in BANNED {
            assert_eq!(check_text(&format!("//! X.\n{text}")).len(), 1, "{text}");
        }
    }

    #[test]
    fn a_test_is_ignored_only_for_what_a_clone_does_not_bring() {
        let [plain, conditional] = IGNORED;
        let faults = |attribute: String| check_text(&format!("//! X.\n{attribute}\nfn f() {{}}\n"));
        for need in NEEDS {
            assert!(faults(format!("{plain} = \"{need}\"]")).is_empty());
            assert_eq!(faults(format!("{plain} = \"{need}, and is slow\"]")).len(), 1);
            assert_eq!(faults(format!("{conditional}(unix, ignore = \"{need}\")]")).len(), 1);
        }
        assert_eq!(faults(format!("{plain}]")).len(), 1);
        assert_eq!(faults(format!("{plain} = \"slow\"]")).len(), 1);
        assert_eq!(faults(format!("{plain} = \"\"]\n{plain}]")).len(), 2);
        assert!(faults(format!("{conditional}(unix, allow(dead_code))]")).is_empty());
    }
}
