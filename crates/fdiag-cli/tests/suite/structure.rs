//! `fdiag structure`, from model files to tables, pictures and JSON.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use std::{
    path::{Path, PathBuf},
    process::{Command, Output},
};

use serde_json::Value;

fn example(path: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    root.join(path).display().to_string()
}

fn structure(out: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fdiag"));
    command.arg("structure").args(arguments).arg("--out").arg(out).output().unwrap()
}

fn said(output: &Output) -> (String, String) {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (text(&output.stdout), text(&output.stderr))
}

#[test]
fn two_tanks_are_told_apart_as_far_as_their_levels_go() {
    let directory = tempfile::tempdir().unwrap();
    let output = structure(directory.path(), &["--model", &example("models/tanks.toml")]);
    let (out, err) = said(&output);
    assert!(output.status.success(), "{err}");
    for part in [
        "tanks: 9 equations, 7 unknowns, redundancy 2.",
        "Of 5 faults 5 can be detected",
        "h_1' = (pump(u) - q_1)/S_1",
        "Minimal test supports",
        "Sensors to isolate all faults",
    ] {
        assert!(out.contains(part), "{part} is not in:\n{out}");
    }
    let read = |name: &str| std::fs::read_to_string(directory.path().join(name)).unwrap();
    for picture in ["structure.svg", "isolability.svg"] {
        assert!(read(picture).starts_with("<svg") && read(picture).contains("f_level_1"));
    }
    assert!(read("report.html").contains("<svg") && read("report.html").contains("d/dt h_2"));
    let json: Value = serde_json::from_str(&read("report.json")).unwrap();
    // The balance of the upper tank and its pump are in one equation with what feeds it: no test divides them.
    let names: Vec<&str> = json["model"]["faults"]
        .as_array()
        .unwrap()
        .iter()
        .map(|f| f["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["f_level_1", "f_level_2", "f_u", "f_h_1", "f_h_2"]);
    let told = |i: usize, j: usize| json["causalities"][0]["isolable"][i][j].as_bool().unwrap();
    assert!(!told(2, 3) && !told(3, 2) && told(0, 2) && told(4, 3));
}

#[test]
fn json_is_printed_when_asked_for() {
    let directory = tempfile::tempdir().unwrap();
    let model = example("models/dc_drive.toml");
    let arguments = ["--model", &model, "--json", "--faults", "all", "--sensors-may-fail"];
    let output = structure(directory.path(), &arguments);
    let (out, err) = said(&output);
    assert!(output.status.success(), "{err}");
    let json: Value = serde_json::from_str(&out).unwrap();
    assert!(json["mso_sets"]["is_complete"].as_bool().unwrap());
    assert_eq!(json["causalities"][1]["causality"], "integral");
}

#[test]
fn every_example_and_a_linear_model_are_read() {
    let directory = tempfile::tempdir().unwrap();
    let models = std::fs::read_dir(example("models")).unwrap();
    let mut models: Vec<PathBuf> = models.map(|entry| entry.unwrap().path()).collect();
    models.push(example("turbine.toml").into());
    for model in models.iter().filter(|model| model.extension().is_some_and(|e| e == "toml")) {
        let output = structure(directory.path(), &["--model", &model.display().to_string()]);
        let (out, err) = said(&output);
        assert!(output.status.success(), "{}: {err}", model.display());
        assert!(out.contains("can be detected"), "{out}");
    }
}

#[test]
fn what_is_wrong_is_named() {
    let directory = tempfile::tempdir().unwrap();
    let tanks = example("models/tanks.toml");
    let process = example("process/cart.toml");
    let cases: [(&[&str], i32, &str); 4] = [
        (&["--model", &tanks, "--faults", "sensors,q_3"], 3, "no fault can be placed at `q_3`"),
        (&["--model", &tanks, "--measurable", "h_9"], 3, "there is no unknown `h_9`; there are u"),
        (&["--model", &process], 3, "a model of kind `process` has no equations"),
        (&["--model", "missing.toml"], 3, "missing.toml"),
    ];
    for (arguments, code, part) in cases {
        let output = structure(directory.path(), arguments);
        let (_, err) = said(&output);
        assert_eq!(output.status.code(), Some(code), "{err}");
        assert!(err.contains(part), "{part} is not in: {err}");
    }
    let output = structure(directory.path(), &["--model", &tanks, "--most", "0"]);
    assert_eq!(output.status.code(), Some(2));
}
