//! Programs as simulators, through the command line: checked, and diagnosed as the plants that they are.
#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a failure here is a failed test")]

use std::{
    path::{Path, PathBuf},
    process::{Command, Output},
};

use fdiag::gap_study::{GapStudy, Request};

const FDIAG: &str = env!("CARGO_BIN_EXE_fdiag");

fn example(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples").join(path)
}

fn fdiag(arguments: &[&str]) -> Output {
    Command::new(FDIAG).args(arguments).output().unwrap()
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn a_program_in_order_is_said_to_be_and_costed() {
    let model = example("gap/quick-start/model.toml").display().to_string();
    let output = fdiag(&["simulator", "check", "--", FDIAG, "simulator", "serve", &model]);
    let said = text(&output);
    assert!(output.status.success(), "{said}");
    for part in [
        "cart, a step every 0.01 s",
        "Powers: step by step, whole runs in one call, outputs before a step, shows its states",
        "fine    repeatability: the same run three times gives the same bits",
        "fine    parameters: each of 2 moves an output",
        "fine    ports: each of 1 moves an output",
        "moves speed",
        " runs (at most)",
        "for 10000 runs (thorough: pairs tried)",
        "\nIn order.\n",
    ] {
        assert!(said.contains(part), "{part} is not in:\n{said}");
    }
}

#[test]
fn what_is_broken_ends_with_exit_code_1_and_its_reason() {
    let directory = tempfile::tempdir().unwrap();
    let model = directory.path().join("model.toml");
    let plant = std::fs::read_to_string(example("gap/quick-start/model.toml")).unwrap();
    std::fs::write(
        &model,
        plant.replace("[inputs]", "idle = { unit = \"1\", value = 2.0 }\n[inputs]"),
    )
    .unwrap();
    let model = model.display().to_string();
    let output = fdiag(&["simulator", "check", "--", FDIAG, "simulator", "serve", &model]);
    let said = text(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.contains("BROKEN  parameters: no output moves with `idle`: is it applied?"),
        "{said}"
    );

    let output = fdiag(&["simulator", "check", "--", "./nobody"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(
        text(&output).starts_with("Broken: `./nobody` cannot be started: "),
        "{}",
        text(&output)
    );
    let output = fdiag(&["simulator", "check", "no-such-model.toml"]);
    assert_eq!(output.status.code(), Some(3));
    assert_eq!(fdiag(&["simulator", "check"]).status.code(), Some(2));
}

/// The cart of the quick start has dry friction, which no model of it has. As text and as a program it gets the
/// same answer, with the same strength, but for what forces lose that are held for a step.
#[test]
fn a_diagnosis_of_a_program_is_that_of_the_equations() {
    let directory = tempfile::tempdir().unwrap();
    let equations = example("gap/quick-start/model.toml").canonicalize().unwrap();
    let process = directory.path().join("process.toml");
    let command = format!("[{FDIAG:?}, \"simulator\", \"serve\", {equations:?}]");
    let file = format!("version = 1\nkind = \"process\"\nworkers = 2\ncommand = {command}\n");
    std::fs::write(&process, file).unwrap();
    let diagnose = |model: &Path| {
        let only =
            ["coulomb-friction", "input-gain", "input-dead-zone", "sensor-lag", "input-delay"];
        let mut request = Request::new(model, [example("gap/quick-start/monday.csv")]);
        request.only = only.map(str::to_owned).to_vec();
        request.most = 1;
        request.as_read = true;
        GapStudy::run(&request, &()).unwrap()
    };
    let [text, program] = [&equations, &process].map(|model| diagnose(model));
    let (counts, trouble) = program.outside.clone().unwrap();
    println!("{counts:?}; counted in the report: {}", program.report.diagnosis.simulations);
    assert_eq!((trouble, counts.deaths, counts.lost), (None, 0, 0));
    assert!(counts.started <= 2 && counts.made < counts.asked);
    assert!(text.outside.is_none());

    let [text, program] = [&text, &program].map(|study| &study.report.diagnosis);
    assert_eq!(text.verdict, program.verdict);
    let [a, b] = [&text.causes[0], &program.causes[0]];
    assert_eq!((a.label, a.site.name()), ("coulomb-friction", Some("rail")));
    assert_eq!((a.label, a.site.name()), (b.label, b.site.name()));
    let [a, b] = [&a.parameters[0], &b.parameters[0]];
    println!("{} +- {}, {} +- {}", a.value, a.standard_error, b.value, b.standard_error);
    // A force that is held for 10 ms blunts the law of friction where the cart turns round, and the fit of the
    // program is seven times less sure of it: 0.354 +- 0.001 and 0.341 +- 0.008 N.
    let sure = 3.0 * a.standard_error.hypot(b.standard_error);
    assert!((a.value - b.value).abs() < sure, "{} {}", a.value, b.value);
}

/// A model file that is named without a folder is in the folder that one is in.
#[test]
fn a_program_is_found_beside_its_file_from_there_as_well() {
    let mut command = Command::new(FDIAG);
    let check = ["simulator", "check", "cart.toml", "--samples", "50"];
    let output = command.args(check).current_dir(example("process")).output().unwrap();
    assert!(output.status.success(), "{}", text(&output));
}

/// The examples in other languages are the cart, too.
#[test]
fn the_example_in_python_is_in_order() {
    let model = example("process/cart.toml").display().to_string();
    let output = fdiag(&["simulator", "check", &model, "--samples", "100"]);
    let said = text(&output);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("\nIn order.\n"), "{said}");
}

/// A budget bounds the runs, says what it left out, and is refused with what is needed where it is too small.
#[test]
fn a_budget_is_kept_or_refused() {
    let model = example("process/cart.toml").display().to_string();
    let log = example("gap/quick-start/monday.csv").display().to_string();
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path().join("report").display().to_string();
    let gap = |budget: &str| {
        fdiag(&[
            "gap",
            "--model",
            &model,
            "--log",
            &log,
            "--out",
            &out,
            "--budget",
            budget,
            "--as-read",
        ])
    };
    let refused = gap("10runs");
    assert_eq!(refused.status.code(), Some(4));
    let message = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(message.contains("--budget: expected at least 67 runs"), "{message}");
    assert!(message.contains("found 10 runs"), "{message}");
    assert_eq!(gap("10").status.code(), Some(2));

    assert!(gap("80runs").status.success());
    let report = std::fs::read_to_string(Path::new(&out).join("report.json")).unwrap();
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    assert_eq!(report["diagnosis"]["causes"][0]["label"], "coulomb-friction");
    let sparing = &report["sparing"];
    println!("{sparing}");
    assert_eq!(sparing["budget"], "80 runs");
    let number = |key: &str| sparing[key].as_u64().unwrap();
    assert!(number("confirmed") < number("proposed"));
    assert!(!sparing["left_out"].as_array().unwrap().is_empty());
}
