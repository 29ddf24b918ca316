//! What a file names is executed by commands that say so, and by no other; `--no-programs` forbids it to all.
#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use std::{
    fs,
    path::PathBuf,
    process::{Command, Output, Stdio},
};

use crate::folder::Folder;

/// A folder with examples, and with a program in `trap.toml` that leaves a file behind where it is started.
struct Desk(Folder);

impl Desk {
    fn new() -> Self {
        let desk = Self(Folder::of(&[
            ("gap/quick-start/monday.csv", "monday.csv"),
            ("turbine.toml", "turbine.toml"),
            ("turbine-run.csv", "run.csv"),
        ]));
        let trap = "version = 1\nkind = \"process\"\ncommand = [\"touch\", \"started\"]\n";
        fs::write(desk.path("trap.toml"), trap).unwrap();
        fs::write(desk.path("fmu.toml"), "version = 1\nkind = \"fmu\"\nfmu = \"a.fmu\"\n").unwrap();
        fs::write(desk.path("a.fmu"), "PK").unwrap();
        let spec = "[generator]\nkind = \"patched\"\nmodel = \"trap.toml\"\n";
        fs::write(desk.path("spec.toml"), spec).unwrap();
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path(name)
    }

    fn run(&self, line: &str) -> Output {
        Command::new(env!("CARGO_BIN_EXE_fdiag"))
            .args(line.split_whitespace())
            .current_dir(self.0.root())
            .stdin(Stdio::null())
            .output()
            .unwrap()
    }

    fn has_started(&self) -> bool {
        self.path("started").exists()
    }
}

/// What shows that the tests below would see it.
#[test]
fn commands_for_simulators_start_them() {
    for line in [
        "gap --model trap.toml --log monday.csv --out made",
        "calibrate --model trap.toml --log monday.csv",
        "simulator check trap.toml",
        "simulator check -- touch started",
    ] {
        let desk = Desk::new();
        desk.run(line);
        assert!(desk.has_started(), "{line}");
    }
}

#[test]
fn forbidden_programs_are_refused_with_the_way_out() {
    for (line, place, what) in [
        ("gap --model trap.toml --log monday.csv --out made", "trap.toml: ", "`touch started`"),
        ("gap --model trap.toml --print-model", "trap.toml: ", "`touch started`"),
        ("calibrate --model trap.toml --log monday.csv", "trap.toml: ", "`touch started`"),
        ("simulator check trap.toml", "trap.toml: ", "`touch started`"),
        ("simulator serve trap.toml", "trap.toml: ", "`touch started`"),
        ("simulator check -- touch started", "", "`touch started`"),
        (
            "gap --model fmu.toml --log monday.csv --out made",
            "fmu.toml: ",
            "the library in `a.fmu`",
        ),
        ("simulator check fmu.toml", "fmu.toml: ", "the library in `a.fmu`"),
        ("simulator serve fmu.toml", "a.fmu: ", "the library in it"),
        ("simulator serve a.fmu", "a.fmu: ", "the library in it"),
    ] {
        let desk = Desk::new();
        for line in [format!("--no-programs {line}"), line.replacen(' ', " --no-programs ", 1)] {
            let output = desk.run(&line);
            let error = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(3), "{line}: {error}");
            let would = format!("{what} would be executed, and programs are forbidden here");
            for word in [place, &would, "without `--no-programs`"] {
                assert!(error.contains(word), "{line}: `{word}` is not in {error}");
            }
            assert!(!desk.has_started(), "{line}");
        }
    }
}

/// These have no need of the switch: each gets the program at every place where it takes a model or a setting.
#[test]
fn commands_for_logs_never_start_a_program() {
    for line in [
        "log info trap.toml",
        "log info monday.csv --columns trap.toml",
        "compensate --model trap.toml --log run.csv --out made",
        "compensate --model trap.toml --print-spec",
        "compensate --model turbine.toml --log run.csv --spec trap.toml --out made",
        "compensate --model turbine.toml --log run.csv --spec spec.toml --out made",
        "compensate --model turbine.toml --log run.csv --columns trap.toml --out made",
        "watch --model trap.toml --healthy run.csv",
        "watch --model turbine.toml --healthy run.csv --spec spec.toml",
        "watch --model turbine.toml --healthy run.csv --diagnose 1 --diagnose-model trap.toml",
        "watch --replay trap.toml",
        "structure --model trap.toml --out made",
    ] {
        let desk = Desk::new();
        let output = desk.run(line);
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success(), "{line}: {error}");
        assert!(!error.contains("panicked"), "{line}: {error}");
        assert!(!desk.has_started(), "{line}");
    }
    let desk = Desk::new();
    let output = desk.run(
        "watch --model turbine.toml --healthy run.csv --diagnose 1 --diagnose-model trap.toml",
    );
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(error.contains("a monitor runs no programs"), "{error}");
}
