//! No building is a slab: what share of the code a crate may hold.

use std::{fs, path::Path};

use crate::sources::{Faults, read, rust_files};

/// Largest share of all lines of code, tests among them, that one crate may hold.
const MOST: f64 = 0.17;

/// Counts the lines of every crate below `root`.
pub(crate) fn check(root: &Path) -> Faults {
    let crates = root.join("crates");
    let mut lines = Vec::new();
    for entry in fs::read_dir(&crates).map_err(|e| format!("{}: {e}", crates.display()))? {
        let path = entry.map_err(|e| e.to_string())?.path();
        let mut files = Vec::new();
        rust_files(&path, &mut files)?;
        let mut count = 0;
        for file in files {
            count += read(&file)?.lines().count();
        }
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        lines.push((name, count));
    }
    Ok(too_large(&lines))
}

fn too_large(lines: &[(String, usize)]) -> Vec<String> {
    let all: usize = lines.iter().map(|(_, count)| count).sum();
    let share = |count: usize| count as f64 / all as f64;
    lines
        .iter()
        .filter(|(_, count)| share(*count) > MOST)
        .map(|(name, count)| {
            let percent = 100.0 * share(*count);
            format!(
                "{name}: {count} lines are {percent:.1} % of the code, at most {:.0} %",
                100.0 * MOST
            )
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slab_is_found() {
        let mut lines: Vec<(String, usize)> = (0..9).map(|i| (format!("fd-{i}"), 100)).collect();
        assert!(too_large(&lines).is_empty());
        lines[3].1 = 200;
        assert_eq!(too_large(&lines), ["fd-3: 200 lines are 20.0 % of the code, at most 17 %"]);
    }
}
