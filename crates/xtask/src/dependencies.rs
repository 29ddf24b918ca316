//! Who may know whom: the arrows of ARCHITECTURE.md, checked against the manifests.

use std::{fs, path::Path};

use crate::sources::{Faults, read};

/// In-tree crates that each crate may import, in groups. Method crates are siblings: none knows another.
const ALLOWED: [(&str, &[&[&str]]); 24] = [
    ("fd-core", &[]),
    ("fd-report", &[]),
    ("fd-numeric", &[&["fd-core"]]),
    ("fd-model", &[&["fd-core", "fd-numeric"]]),
    ("fd-log", &[MODELS, &["fd-sim"]]),
    ("fd-sim", &[MODELS]),
    ("fd-residual", &[MODELS]),
    ("fd-ident", &[MODELS]),
    ("fd-compensate", &[MODELS]),
    ("fd-jetengine", &[MODELS]),
    ("fd-data", &[MODELS]),
    ("fd-structure", &[MODELS, &["fd-sim"]]),
    ("fd-nonlinear", &[MODELS, &["fd-sim"]]),
    ("fd-effect", &[MODELS, &["fd-sim"]]),
    ("fd-gap", &[MODELS, &["fd-sim", "fd-effect", "fd-residual", "fd-ident", "fd-compensate"]]),
    ("fdiag", &[MODELS, METHODS]),
    ("fd-watch", &[MODELS, &["fd-log", "fdiag"]]),
    ("fd-console", &[&["fd-report", "fdiag"]]),
    ("fd-lab", &[MODELS, METHODS, &["fd-report", "fdiag", "fd-console"]]),
    ("fd-page", &[MODELS, METHODS, &["fd-report", "fdiag"]]),
    ("fd-python", &[MODELS, METHODS, &["fdiag", "fd-page", "fdiag-cli"]]),
    ("fdiag-cli", &[MODELS, METHODS, &["fd-report", "fdiag", "fd-console", "fd-page", "fd-watch"]]),
    ("fdiag-benches", &[MODELS, METHODS, &["fdiag", "fd-lab"]]),
    ("xtask", &[]),
];
/// What every crate of methods stands on.
const MODELS: &[&str] = &["fd-core", "fd-numeric", "fd-model"];
/// What the facade joins.
const METHODS: &[&str] = &[
    "fd-log",
    "fd-sim",
    "fd-structure",
    "fd-nonlinear",
    "fd-data",
    "fd-residual",
    "fd-ident",
    "fd-compensate",
    "fd-jetengine",
    "fd-effect",
    "fd-gap",
];

/// Checks the manifests of all crates below `root`.
pub(crate) fn check(root: &Path) -> Faults {
    let mut faults = Vec::new();
    let mut directories = vec![root.join("benches")];
    let crates = root.join("crates");
    for entry in fs::read_dir(&crates).map_err(|e| format!("{}: {e}", crates.display()))? {
        directories.push(entry.map_err(|e| e.to_string())?.path());
    }
    for directory in directories {
        let path = directory.join("Cargo.toml");
        let text = read(&path)?;
        faults.extend(check_manifest(&text).map_err(|e| format!("{}: {e}", path.display()))?);
    }
    Ok(faults)
}

fn check_manifest(text: &str) -> Faults {
    let manifest: toml::Table = text.parse().map_err(|e: toml::de::Error| e.to_string())?;
    let name = manifest
        .get("package")
        .and_then(|package| package.get("name"))
        .and_then(toml::Value::as_str)
        .ok_or("no package name")?;
    let Some((_, allowed)) = ALLOWED.iter().find(|(known, _)| *known == name) else {
        return Ok(vec![format!("{name}: not in the dependency rules of xtask")]);
    };
    let tables = ["dependencies", "dev-dependencies", "build-dependencies"];
    let names = tables
        .iter()
        .filter_map(|table| manifest.get(*table)?.as_table())
        .flat_map(toml::Table::keys)
        .filter(|dependency| dependency.starts_with("fd-") || *dependency == "fdiag");
    Ok(names
        .filter(|dependency| {
            *dependency != name && !allowed.concat().contains(&dependency.as_str())
        })
        .map(|dependency| format!("{name} must not depend on {dependency}"))
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn siblings_must_not_know_each_other() {
        let manifest = "[package]\nname = \"fd-ident\"\n[dependencies]\nfd-core.workspace = true\n\
                        [dev-dependencies]\nfd-residual.workspace = true";
        assert_eq!(
            check_manifest(manifest),
            Ok(vec!["fd-ident must not depend on fd-residual".to_owned()])
        );
    }

    #[test]
    fn an_unknown_crate_needs_a_rule() {
        let faults = check_manifest("[package]\nname = \"fd-new\"").unwrap();
        assert_eq!(faults.len(), 1);
    }
}
