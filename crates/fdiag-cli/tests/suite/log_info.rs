//! `fdiag log info` as a user meets it.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use std::process::{Command, Output};

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../fd-log/tests/data/");

fn info(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fdiag"));
    command.args(["log", "info"]).args(arguments).output().unwrap()
}

#[test]
fn a_log_is_described_for_people_and_as_json() {
    let file = format!("{DATA}run.csv.gz");
    let told = String::from_utf8(info(&[&file]).stdout).unwrap();
    for part in ["CSV in gzip", "50 rows, 3 columns", "time t: 0 to 4.90 s", "degC"] {
        assert!(told.contains(part), "{told}");
    }
    let json = info(&[&file, "--json"]).stdout;
    let json: serde_json::Value = serde_json::from_slice(&json).unwrap();
    assert_eq!(json["tables"][0]["columns"][2]["most"], 32.25);
}

#[test]
fn what_is_no_log_is_an_input_error() {
    let missing = info(&["nowhere.npz"]);
    assert_eq!(missing.status.code(), Some(3));
    assert!(String::from_utf8_lossy(&missing.stderr).contains("nowhere.npz"));
}
