//! Which licences the dependencies may have, and which crates may appear in two versions: `deny.toml`, without a network.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
    process::Command,
};

use crate::sources::{Faults, read};

/// What `deny.toml` allows.
#[derive(Debug, Default)]
struct Rules {
    /// Licences.
    licences: Vec<String>,
    /// Crates that may be built in several versions, or versions of a crate that may be there beside another.
    duplicates: Vec<(String, Option<String>)>,
}

impl Rules {
    /// Whether a version, such as `v1.2.3`, may be there beside others.
    fn skips(&self, name: &str, version: &str) -> bool {
        let is_of = |part: &str| {
            let rest = version.strip_prefix('v').and_then(|version| version.strip_prefix(part));
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        let mut of_name = self.duplicates.iter().filter(|(known, _)| known == name);
        of_name.any(|(_, part)| part.as_deref().is_none_or(is_of))
    }
}

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
    let rules = rules(&read(&root.join("deny.toml"))?)?;
    Ok(check_tree(&String::from_utf8_lossy(&output.stdout), &rules))
}

/// Reads the rules.
fn rules(text: &str) -> Result<Rules, String> {
    let table: toml::Table =
        text.parse().map_err(|e: toml::de::Error| format!("deny.toml: {e}"))?;
    let list = |section: &str, key: &str| {
        let list = table.get(section).and_then(|section| section.get(key)?.as_array());
        list.ok_or_else(|| format!("deny.toml has no list {section}.{key}"))
    };
    let text = |entry: &toml::Value| entry.as_str().map(str::to_owned);
    let licences = list("licenses", "allow")?.iter().filter_map(text).collect();
    let skipped = list("bans", "skip")?.iter().filter_map(|entry| entry.get("crate")?.as_str());
    let duplicates = skipped.map(|skipped| match skipped.split_once('@') {
        Some((name, version)) => (name.to_owned(), Some(version.to_owned())),
        None => (skipped.to_owned(), None),
    });
    let duplicates = duplicates.collect();
    Ok(Rules { licences, duplicates })
}

/// Checks lines of the form `name v1.2.3 (notes)|licence`.
fn check_tree(tree: &str, rules: &Rules) -> Vec<String> {
    let mut faults = Vec::new();
    let mut versions: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    let lines: BTreeSet<&str> = tree.lines().filter(|line| !line.is_empty()).collect();
    for (package, licence) in lines.iter().filter_map(|line| line.split_once('|')) {
        let mut words = package.split(' ');
        let (name, version) = (words.next().unwrap_or(""), words.next().unwrap_or(""));
        if versions.entry(name).or_default().insert(version) && !is_allowed(licence, rules) {
            faults.push(format!("{name} {version}: licence `{licence}` is not on the list"));
        }
    }
    for (name, mut versions) in versions {
        versions.retain(|version| !rules.skips(name, version));
        if versions.len() > 1 {
            let versions: Vec<&str> = versions.into_iter().collect();
            faults.push(format!("{name} is built in versions {}", versions.join(", ")));
        }
    }
    faults
}

fn is_allowed(licence: &str, rules: &Rules) -> bool {
    let is_listed = |id: &str| rules.licences.iter().any(|known| known == id);
    spdx::Expression::parse_mode(licence, spdx::ParseMode::LAX)
        .is_ok_and(|e| e.evaluate(|r| r.license.id().is_some_and(|id| is_listed(id.name))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn licences_and_duplicates_are_found() {
        let tree = "a v1.0.0|MIT OR Apache-2.0\nb v1.0.0 (proc-macro)|AGPL-3.0-only\n\
                    b v2.0.0|MIT/Apache-2.0\nb v2.0.0|MIT/Apache-2.0\n";
        let text = "licenses.allow = [\"MIT\"]\nbans.skip = []\n";
        let faults = check_tree(tree, &rules(text).unwrap());
        assert_eq!(faults.len(), 2, "{faults:?}");
        assert!(faults[0].contains("AGPL-3.0-only"));
        assert!(faults[1].contains("v1.0.0, v2.0.0"));
        let text =
            "licenses.allow = [\"MIT\", \"AGPL-3.0-only\"]\nbans.skip = [{ crate = \"b@1\" }]\n";
        assert_eq!(check_tree(tree, &rules(text).unwrap()), Vec::<String>::new());
        assert!(rules("").is_err());
        let rules =
            rules("licenses.allow = []\nbans.skip = [{ crate = \"b@1\" }, { crate = \"c\" }]\n")
                .unwrap();
        assert!(
            rules.skips("b", "v1.0.0")
                && !rules.skips("b", "v10.0.0")
                && rules.skips("c", "v2.0.0")
        );
    }
}
