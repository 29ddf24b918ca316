//! The facade stays lean: what a user of the library must not have to compile.

use std::{path::Path, process::Command};

use crate::sources::Faults;

/// Crates that belong to the command line, to reports and to sealed experiments.
const NOT_IN_THE_FACADE: [&str; 7] =
    ["clap", "plotters", "maud", "comfy-table", "indicatif", "sha2", "getrandom"];

/// Checks what a dependency on `fdiag` brings with it.
pub(crate) fn check(root: &Path) -> Faults {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let output = Command::new(cargo)
        .args(["tree", "--package", "fdiag", "--edges", "normal", "--locked", "--prefix", "none"])
        .current_dir(root)
        .output()
        .map_err(|e| format!("cargo tree: {e}"))?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into_owned());
    }
    Ok(check_tree(&String::from_utf8_lossy(&output.stdout)))
}

/// Checks lines of the form `name v1.2.3 (notes)`.
fn check_tree(tree: &str) -> Vec<String> {
    let names: Vec<&str> = tree.lines().filter_map(|line| line.split(' ').next()).collect();
    let heavy = NOT_IN_THE_FACADE.iter().filter(|heavy| names.contains(heavy));
    heavy.map(|heavy| format!("the library fdiag must not depend on {heavy}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_heavy_dependency_is_found() {
        let faults = check_tree("fdiag v0.1.0\nclap v4.5.0\nclap_lex v0.7.0\nserde v1.0.0\n");
        assert_eq!(faults, ["the library fdiag must not depend on clap"]);
    }
}
