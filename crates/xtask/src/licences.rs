//! Which licences the dependencies may have, and which crates may appear in two versions.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
    process::Command,
};

use crate::Faults;

/// Licences that go with MIT / Apache-2.0 without further duties for users.
const ALLOWED: [&str; 9] = [
    "MIT",
    "Apache-2.0",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "ISC",
    "Zlib",
    "Unicode-3.0",
    "BSL-1.0",
    "CC0-1.0",
];

/// Crates that may be built in several versions: macro helpers of faer's matrix kernels and of
/// serde, clap and thiserror, which have not all moved to the same generation yet.
const DUPLICATES: [&str; 3] = ["equator", "equator-macro", "syn"];

/// Checks everything that a build, a test or a benchmark compiles on this platform.
pub(crate) fn check(root: &Path) -> Faults {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let output = Command::new(cargo)
        .args(["tree", "--workspace", "--locked", "--prefix", "none", "--no-dedupe"])
        .args(["--format", "{p}|{l}"])
        .current_dir(root)
        .output()
        .map_err(|e| format!("cargo tree: {e}"))?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into_owned());
    }
    Ok(check_tree(&String::from_utf8_lossy(&output.stdout)))
}

/// Checks lines of the form `name v1.2.3 (notes)|licence`.
fn check_tree(tree: &str) -> Vec<String> {
    let mut faults = Vec::new();
    let mut versions: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    let lines: BTreeSet<&str> = tree.lines().filter(|line| !line.is_empty()).collect();
    for (package, licence) in lines.iter().filter_map(|line| line.split_once('|')) {
        let mut words = package.split(' ');
        let (name, version) = (words.next().unwrap_or(""), words.next().unwrap_or(""));
        if versions.entry(name).or_default().insert(version) && !is_allowed(licence) {
            faults.push(format!("{name} {version}: licence `{licence}` is not on the list"));
        }
    }
    for (name, versions) in versions {
        if versions.len() > 1 && !DUPLICATES.contains(&name) {
            let versions: Vec<&str> = versions.into_iter().collect();
            faults.push(format!("{name} is built in versions {}", versions.join(", ")));
        }
    }
    faults
}

fn is_allowed(licence: &str) -> bool {
    spdx::Expression::parse_mode(licence, spdx::ParseMode::LAX)
        .is_ok_and(|e| e.evaluate(|r| r.license.id().is_some_and(|id| ALLOWED.contains(&id.name))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn licences_and_duplicates_are_found() {
        let tree = "a v1.0.0|MIT OR Apache-2.0\nb v1.0.0 (proc-macro)|AGPL-3.0-only\n\
                    b v2.0.0|MIT/Apache-2.0\nb v2.0.0|MIT/Apache-2.0\n";
        let faults = check_tree(tree);
        assert_eq!(faults.len(), 2, "{faults:?}");
        assert!(faults[0].contains("AGPL-3.0-only"));
        assert!(faults[1].contains("v1.0.0, v2.0.0"));
    }
}
