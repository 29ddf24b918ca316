//! Programs that are no simulators, and files that say too little or too much.

use std::{path::Path, time::Duration};

use fd_sim::outside::{OutsideError, OutsideFile, Process};

use super::{open, process};

fn refusal(manner: &str) -> String {
    let mut process = process(&[manner]);
    process.timeout = Duration::from_millis(if manner == "endless" { 300 } else { 20_000 });
    open(process, 1).unwrap_err().to_string()
}

#[test]
fn a_program_that_is_not_there() {
    let error = open(Process::new(["./nobody", "--stdio"]), 1).unwrap_err().to_string();
    assert!(error.starts_with("`./nobody --stdio` cannot be started: "), "{error}");
    let error = open(Process::new(Vec::<String>::new()), 1).unwrap_err();
    assert!(matches!(error, OutsideError::Start { .. }), "{error}");
}

#[test]
fn a_wrong_hello_is_quoted() {
    for (manner, part) in [
        ("chatty", "has answered to hello with `Loading the model ...`"),
        ("old", "version 0, expected version 1 of the protocol"),
        ("empty", "outputs: expected at least one, found none"),
        ("unknown", "unknown field `units`"),
        ("wordy", "6 bytes more after the line"),
        ("endless", "has not answered to hello within 0.3 s"),
        ("quit", "has ended (exit status: 7) when asked for hello"),
    ] {
        let error = refusal(manner);
        assert!(error.contains(part), "{manner}: {error}");
    }
}

fn parse(text: &str) -> Result<OutsideFile, OutsideError> {
    OutsideFile::parse(Path::new("model/mass.toml"), text)
}

#[test]
fn a_file_says_what_is_wrong_with_it() {
    let head = "version = 1\nkind = \"process\"\n";
    for (text, part) in [
        ("command = []", "command: expected a program, found none"),
        ("command = [\"a\"]\nworkers = 0", "workers: expected at least 1, found 0"),
        ("command = [\"a\"]\ntimeout = -1.0", "timeout: expected seconds above 0, found -1"),
        ("command = [\"a\"]\ncolour = 1", "unknown field `colour`"),
        (
            "command = [\"a\"]\n[inputs]\nu = { unit = \"V\", noise = 1.0 }",
            "inputs.u: expected `unit`, `variable`, found `noise`",
        ),
    ] {
        let error = parse(&format!("{head}{text}")).unwrap_err().to_string();
        assert!(error.starts_with("model/mass.toml: ") && error.contains(part), "{error}");
    }
}

/// A file of the awkward simulator.
fn file(more: &str) -> OutsideFile {
    let program = env!("CARGO_BIN_EXE_awkward-simulator");
    let head = format!("version = 1\nkind = \"process\"\ncommand = [\"{program}\"]\n");
    let text = format!("directory = \"..\"\n{head}{more}");
    OutsideFile::parse(Path::new("testing/mass.toml"), &text).unwrap()
}

#[test]
fn a_file_may_know_better_but_names_are_those_of_the_simulator() {
    let simulator = file("[parameters]\nd = { tolerance = 0.5 }").open().unwrap();
    assert_eq!(simulator.contract().parameters[1].tolerance.to_bits(), 0.5_f64.to_bits());
    assert_eq!(simulator.contract().parameters[1].value.to_bits(), 0.8_f64.to_bits());
    for (more, part) in [
        ("[parameters]\nmm = { tolerance = 0.5 }", "names out of `m`, `d`, `k`, found `mm`"),
        ("[parameters]\nm = { value = 2.0, bounds = [3.0, 4.0] }", "bounds around its value 2"),
        ("[parameters]\nm = { tolerance = -0.1 }", "a tolerance from 0 on"),
        ("[outputs]\nspeed = { noise = 0.0 }", "outputs.speed: expected noise above 0"),
        ("[ports]\nrail = { velocity = \"v\" }", "an output out of `place`, `speed`"),
    ] {
        let error = file(more).open().unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn what_a_diagnosis_writes_is_read_again() {
    use fd_sim::simulate::Nominal;
    let first = file("# A comment.\nsample_time = 0.04\n[parameters]\nd = { tolerance = 0.5 }");
    let simulator = first.open().unwrap();
    let shell = first.shell(&simulator).unwrap();
    assert_eq!(shell.model().sample_time.to_bits(), 0.04_f64.to_bits());
    let text = first.text(shell.model());
    assert!(text.contains("# A comment.") && text.matches("directory").count() == 1, "{text}");
    let second = OutsideFile::parse(Path::new("elsewhere/patched.toml"), &text).unwrap();
    let again = second.shell(&second.open().unwrap()).unwrap();
    assert_eq!(again.model(), shell.model());
    // Once more, and nothing is doubled.
    assert_eq!(second.text(again.model()), text);
    let every = |text: &str| file(text).shell(&file(text).open().unwrap()).unwrap_err().to_string();
    assert!(every("sample_time = 0.03").contains("a whole number of times per sample"));
    assert_eq!(shell.simulator(super::ts()).unwrap().outputs().len(), 2);
}
