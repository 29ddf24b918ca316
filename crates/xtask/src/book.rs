//! `cargo xtask book`: the documentation as a site, with reports of the examples in it.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use crate::sources::Faults;

/// Reports of the gallery: name of the folder, and what `fdiag` is asked.
const GALLERY: [(&str, &[&str]); 3] = [
    ("demo", &["demo"]),
    (
        "quick-start",
        &[
            "gap",
            "--model",
            "examples/gap/quick-start/model.toml",
            "--log",
            "examples/gap/quick-start/monday.csv",
            "--held-out",
            "examples/gap/quick-start/friday.csv",
        ],
    ),
    (
        "worn-engine",
        &[
            "gap",
            "--model",
            "examples/gap/engine/engine.toml",
            "--log",
            "examples/gap/engine/worn.csv",
        ],
    ),
];

/// Builds the site into `target/book`. Needs `mdbook` (`cargo install mdbook --locked`).
pub(crate) fn build(root: &Path) -> Faults {
    let (source, site) = (root.join("target/book-source"), root.join("target/book"));
    if source.exists() {
        fs::remove_dir_all(&source).map_err(|e| format!("{}: {e}", source.display()))?;
    }
    copy(&root.join("docs"), &source)?;
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    for (name, question) in GALLERY {
        let out = source.join("gallery").join(name);
        run(Command::new(&cargo)
            .args(["run", "--release", "--quiet", "--package", "fdiag-cli", "--"])
            .args(question)
            .arg("--out")
            .arg(out)
            .current_dir(root))?;
    }
    run(Command::new("mdbook").arg("build").arg(&source).arg("--dest-dir").arg(&site))
        .map_err(|e| format!("{e}; `cargo install mdbook --locked` brings it"))?;
    Ok(Vec::new())
}

fn run(command: &mut Command) -> Result<(), String> {
    let program = command.get_program().to_string_lossy().into_owned();
    let status = command.status().map_err(|e| format!("{program}: {e}"))?;
    if status.success() { Ok(()) } else { Err(format!("{program}: {status}")) }
}

fn copy(from: &Path, to: &PathBuf) -> Result<(), String> {
    let failed = |e: std::io::Error| format!("{}: {e}", from.display());
    fs::create_dir_all(to).map_err(failed)?;
    for entry in fs::read_dir(from).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let Some(name) = path.file_name() else { continue };
        if path.is_dir() {
            copy(&path, &to.join(name))?;
        } else {
            fs::copy(&path, to.join(name)).map_err(failed)?;
        }
    }
    Ok(())
}
