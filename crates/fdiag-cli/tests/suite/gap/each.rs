//! `--each`: every log by itself, and what the answers agree on.

use crate::gap::desk::{Desk, stdout};

/// What was written of all logs together.
fn compared(desk: &Desk) -> serde_json::Value {
    serde_json::from_str(&desk.read("out/report.json")).unwrap()
}

/// Both logs of the quick start are of one cart, whose rail rubs with 0.35 N.
#[test]
fn two_logs_of_one_cart_agree() {
    let desk = Desk::new();
    let output = desk.run(&[
        "--model",
        "model.toml",
        "--log",
        "monday.csv",
        "--log",
        "friday.csv",
        "--each",
        "--only",
        "coulomb-friction",
        "--only",
        "input-delay",
        "--out",
        "out",
    ]);
    let text = stdout(&output);
    assert!(output.status.success(), "{output:?}");
    assert!(text.starts_with("Both logs name Coulomb friction at rail (0.35"), "{text}");
    let report = compared(&desk);
    let cause = &report["causes"][0];
    assert_eq!(
        (cause["label"].as_str(), cause["named"].as_u64()),
        (Some("coulomb-friction"), Some(2))
    );
    let strength = &cause["strengths"][0];
    let [mean, error, differ] =
        ["mean", "standard_error", "differ"].map(|key| strength[key].as_f64().unwrap());
    assert!((mean - 0.35).abs() < 4.0 * error && error < 0.002, "{mean} +- {error}");
    // Of two logs, the root of a square with one degree of freedom: beyond 3 once in 400 pairs.
    assert!(differ < 3.0, "{differ}");
    for log in ["monday", "friday"] {
        let page = desk.read(&format!("out/{log}/report.html"));
        assert!(page.contains("Coulomb friction"), "{log}");
        desk.read(&format!("out/{log}/patched.toml"));
    }
}

/// A log that cannot be read is told beside the others; where none can, the command fails as it does for one.
#[test]
fn a_log_without_an_answer_stands_beside_the_others() {
    let desk = Desk::new();
    desk.put("broken.csv", "time,force\n0,1\n1,2\n");
    let logs = ["--model", "model.toml", "--log", "monday.csv", "--log", "broken.csv", "--each"];
    let few = ["--only", "coulomb-friction", "--out", "out"];
    let output = desk.run(&[&logs[..], &few].concat());
    assert!(output.status.success(), "{output:?}");
    let text = stdout(&output);
    assert!(text.contains("1 of 2 logs has no answer"), "{text}");
    assert!(compared(&desk)["logs"][1]["headline"].as_str().unwrap().contains("speed"), "{text}");
    let output =
        desk.run(&["--model", "model.toml", "--log", "broken.csv", "--each", "--out", "out"]);
    assert_eq!(output.status.code(), Some(3), "{output:?}");
}
