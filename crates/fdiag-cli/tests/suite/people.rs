//! Other people's simulators and logs, `../shared/data/people`: what each `expected.md` says is right.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use std::{
    path::PathBuf,
    process::{Command, Output},
};

/// A command in one of the folders.
fn fdiag(folder: &str, arguments: &[&str]) -> Output {
    let people = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data/people");
    let folder = PathBuf::from(people).join(folder);
    assert!(folder.is_dir(), "the logs are missing: no folder {}", folder.display());
    let out = tempfile::tempdir().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_fdiag"));
    command.current_dir(folder).args(arguments);
    if arguments[0] == "gap" {
        command.arg("--out").arg(out.path());
    }
    command.output().unwrap()
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

#[test]
#[ignore = "needs the logs of ../shared/data"]
fn a_reset_that_resets_nothing_is_seen() {
    let gap = |log: &str| {
        let [fit, held] = ["fit", "held"].map(|part| format!("{log}-{part}.csv"));
        told(&fdiag(
            "p02-fmu-reset",
            &["gap", "--model", "room.toml", "--log", &fit, "--held-out", &held],
        ))
    };
    let same = gap("same");
    assert!(same.starts_with("No gap"), "{same}");
    let lag = gap("lag");
    assert!(lag.contains("ensor") && lag.contains("ag on output T"), "{lag}");
    let check = told(&fdiag("p02-fmu-reset", &["simulator", "check", "room.toml"]));
    assert!(!check.contains("BROKEN") && check.contains("fresh instance"), "{check}");
}

#[test]
#[ignore = "needs the logs of ../shared/data"]
fn the_held_out_tail_of_a_black_box_is_continued() {
    let gap =
        told(&fdiag("p04-heldout-tail", &["gap", "--model", "room.toml", "--log", "log.csv"]));
    assert!(gap.contains("No gap") && !gap.contains("held-out `T` is missed"), "{gap}");
}

#[test]
#[ignore = "needs the logs of ../shared/data"]
fn the_column_of_time_is_the_right_one() {
    let gap = told(&fdiag("p05-T-as-time", &["gap", "--model", "model.toml", "--log", "log.csv"]));
    assert!(!gap.contains("another unit") && !gap.contains("is it that column"), "{gap}");
}

/// The same on files of our own.
#[test]
fn messages_about_time_name_its_column() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let model = "version = 1\nkind = \"equations\"\nname = \"m\"\nsample_time = 30.0\n\
                 inputs = { P = { unit = \"W\" } }\nparameters = { a = { unit = \"1\", value = 1.0, tolerance = 0.1 } }\n\
                 states = { x = { unit = \"degC\", initial = 20.0, derivative = \"a*P*0.001 - 0.001*x\" } }\n\
                 outputs = { Troom = { unit = \"degC\", value = \"x\" } }\n";
    std::fs::write(path("model.toml"), model).unwrap();
    let rows = |step: f64| -> String {
        let row = |k: i32| format!("{},100,{},20\n", step * f64::from(k), 20 + k % 7);
        (0..200).map(row).collect()
    };
    std::fs::write(path("ms.csv"), format!("timestamp,P,T,Troom\n{}", rows(30_000.0))).unwrap();
    std::fs::write(path("s.csv"), format!("timestamp,P,T,Troom\n{}", rows(30.0))).unwrap();
    let run = |command: &str, log: &str| {
        let mut program = Command::new(env!("CARGO_BIN_EXE_fdiag"));
        program.args([command, "--model", &path("model.toml"), "--log", &path(log)]);
        program.output().unwrap()
    };
    let error = String::from_utf8(run("calibrate", "ms.csv").stderr).unwrap();
    assert!(error.contains("time was read from column `timestamp`"), "{error}");
    assert!(error.contains("unit = \"ms\""), "{error}");
    let table = String::from_utf8(run("calibrate", "s.csv").stdout).unwrap();
    assert!(table.contains("1 parameters") && table.contains("known to"), "{table}");
}
