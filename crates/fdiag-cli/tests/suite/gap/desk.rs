//! A folder with a model and two logs, and the command that is run in it.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use serde_json::Value;
use tempfile::TempDir;

use crate::gap::schema::{faults, schema};

/// A folder with a model and two logs of the quick start, to be spoiled.
pub(crate) struct Desk {
    folder: TempDir,
}

impl Desk {
    pub(crate) fn new() -> Self {
        Self::of("quick-start", &["model.toml", "monday.csv", "friday.csv"])
    }

    /// A folder with files of an example.
    pub(crate) fn of(example: &str, files: &[&str]) -> Self {
        let desk = Self { folder: tempfile::tempdir().unwrap() };
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/gap").join(example);
        for file in files {
            fs::copy(root.join(file), desk.path(file)).unwrap();
        }
        desk
    }

    pub(crate) fn path(&self, file: &str) -> PathBuf {
        self.folder.path().join(file)
    }

    pub(crate) fn read(&self, file: &str) -> String {
        fs::read_to_string(self.path(file)).unwrap()
    }

    pub(crate) fn put(&self, file: &str, content: &str) {
        fs::write(self.path(file), content).unwrap();
    }

    /// Changes the rows of a log: number of the row from 0, and its cells.
    pub(crate) fn spoil(&self, file: &str, change: impl Fn(usize, &mut Vec<String>)) {
        let text = self.read(file);
        let mut row = 0;
        let mut spoiled = String::new();
        for line in text.lines() {
            if line.starts_with('#') {
                continue; // the line that states the sample time exactly
            }
            let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
            if !line.starts_with("time") {
                change(row, &mut cells);
                row += 1;
            }
            if !cells.is_empty() {
                spoiled.push_str(&cells.join(","));
                spoiled.push('\n');
            }
        }
        self.put(file, &spoiled);
    }

    fn in_folder(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fdiag"));
        command.current_dir(self.folder.path()).arg("gap").args(arguments);
        command
    }

    pub(crate) fn run(&self, arguments: &[&str]) -> Output {
        self.in_folder(arguments).output().unwrap()
    }

    /// The plain command with more arguments.
    pub(crate) fn command(&self, more: &[&str]) -> Command {
        let plain = ["--model", "model.toml", "--log", "monday.csv", "--out", "out"];
        self.in_folder(&[&plain, more].concat())
    }

    /// Runs it.
    pub(crate) fn gap(&self, more: &[&str]) -> Output {
        self.command(more).output().unwrap()
    }

    /// What `report.json` says; every one that a test reads is checked against the schema.
    #[track_caller]
    pub(crate) fn report(&self) -> Value {
        self.report_in("out")
    }

    /// The same, of another directory.
    #[track_caller]
    pub(crate) fn report_in(&self, directory: &str) -> Value {
        let report = serde_json::from_str(&self.read(&format!("{directory}/report.json"))).unwrap();
        let faults = faults(&schema(), &report);
        assert!(faults.is_empty(), "not what docs/gap-report.schema.json says: {faults:#?}");
        report
    }
}

pub(crate) fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// Asserts an exit code and that the message has all of these parts; and that nothing was left.
#[track_caller]
pub(crate) fn refuses(desk: &Desk, output: &Output, code: i32, parts: &[&str]) {
    let message = String::from_utf8(output.stderr.clone()).unwrap();
    assert_eq!(output.status.code(), Some(code), "{message}");
    for part in parts {
        assert!(message.contains(part), "`{part}` is not in: {message}");
    }
    assert!(!desk.path("out").exists(), "something was written");
}

/// Only these effects, where a test is not about the answer.
pub(crate) const FEW: [&str; 4] = ["--only", "friction", "--only", "input-delay"];
