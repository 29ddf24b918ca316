//! Every page in a browser: nothing is clipped, no picture is empty, nothing is too faint to read, every picture has a name,
//! shows its values and can be zoomed, and no script complains.
//! On a desk and on a telephone, in the light and in the dark.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a failure here is a failed test"
)]

mod between;
mod browser;
#[cfg(feature = "http")]
mod rebinding;

use std::{
    fs,
    io::{BufRead, BufReader, Write},
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

use crate::watching::Plant;
use browser::Browser;
use tempfile::TempDir;

/// Runs a command in a folder with the examples; where its page is.
fn page(folder: &TempDir, line: &str) -> PathBuf {
    page_of(Path::new(env!("CARGO_BIN_EXE_fdiag")), folder, line)
}

/// The laboratory, which `cargo test --workspace` builds beside.
fn lab() -> PathBuf {
    let path = Path::new(env!("CARGO_BIN_EXE_fdiag")).with_file_name("fdiag-lab");
    assert!(path.exists(), "{} is not there: `cargo build -p fd-lab` makes it", path.display());
    path
}

fn page_of(program: &Path, folder: &TempDir, line: &str) -> PathBuf {
    let examples =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples").canonicalize().unwrap();
    let line = line.replace("examples", examples.to_str().unwrap());
    let output = Command::new(program)
        .args(line.split_whitespace())
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    folder.path().join("fdiag-report/report.html")
}

const GAP: &str =
    "gap --model examples/gap/quick-start/model.toml --log examples/gap/quick-start/monday.csv";

#[test]
#[ignore = "needs chromium"]
fn in_chromium_a_clear_gap_is_in_order() {
    let folder = tempfile::tempdir().unwrap();
    let line = format!("{GAP} --held-out examples/gap/quick-start/friday.csv --calibrate 2");
    let page = page(&folder, &line);
    Browser::new().file_is_in_order("gap, clear", &page, 3);
}

/// A name is long, a log is short, and what there is stays undecided.
#[test]
#[ignore = "needs chromium"]
fn in_chromium_a_gap_that_cannot_be_told_is_in_order() {
    let folder = tempfile::tempdir().unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/gap/quick-start");
    let log = fs::read_to_string(root.join("monday.csv")).unwrap();
    let short: Vec<&str> = log.lines().take(130).collect();
    fs::write(folder.path().join("short.csv"), short.join("\n") + "\n").unwrap();
    let page = page(&folder, "gap --model examples/gap/quick-start/model.toml --log short.csv");
    let report = fs::read_to_string(folder.path().join("fdiag-report/report.json")).unwrap();
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    let verdict = report["diagnosis"]["verdict"].as_str().unwrap().to_owned();
    assert!(["tied", "unclear"].contains(&&*verdict), "{verdict}: {}", report["headline"]);
    Browser::new().file_is_in_order("gap, tied", &page, 3);
}

#[test]
#[ignore = "needs chromium"]
fn in_chromium_no_gap_is_in_order() {
    let folder = tempfile::tempdir().unwrap();
    // The answer of the model itself: what the first diagnosis patched explains the log.
    page(&folder, &format!("{GAP} --held-out examples/gap/quick-start/friday.csv"));
    let patched = folder.path().join("cart.toml");
    fs::rename(folder.path().join("fdiag-report/patched.toml"), patched).unwrap();
    let page = page(&folder, "gap --model cart.toml --log examples/gap/quick-start/monday.csv");
    let report = fs::read_to_string(folder.path().join("fdiag-report/report.json")).unwrap();
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    assert_eq!(report["diagnosis"]["verdict"], "no-gap", "{}", report["headline"]);
    Browser::new().file_is_in_order("gap, none", &page, 2);
}

#[test]
#[ignore = "needs chromium"]
fn in_chromium_a_gap_that_was_stopped_is_in_order() {
    let folder = tempfile::tempdir().unwrap();
    let page = page(&folder, &format!("{GAP} --calibrate 10000 --time-limit 1ms"));
    let text = fs::read_to_string(&page).unwrap();
    assert!(
        text.contains("It was stopped by its time limit of 0.001 s"),
        "the page does not say so"
    );
    Browser::new().file_is_in_order("gap, stopped", &page, 2);
}

#[test]
#[ignore = "needs chromium"]
fn in_chromium_compensate_is_in_order() {
    let folder = tempfile::tempdir().unwrap();
    let line = "compensate --model examples/turbine.toml --log examples/turbine-run.csv --log examples/turbine-run.csv";
    Browser::new().file_is_in_order("compensate", &page(&folder, line), 2);
}

#[test]
#[ignore = "needs chromium"]
fn in_chromium_the_engine_is_in_order() {
    let folder = tempfile::tempdir().unwrap();
    Browser::new().file_is_in_order("engine", &page_of(&lab(), &folder, "engine --seeds 5"), 5);
}

#[test]
#[ignore = "needs chromium"]
fn in_chromium_structure_is_in_order() {
    let folder = tempfile::tempdir().unwrap();
    let line = "structure --model examples/models/tanks.toml";
    Browser::new().file_is_in_order("structure", &page(&folder, line), 2);
}

#[test]
#[ignore = "needs chromium"]
fn in_chromium_the_comparison_is_in_order() {
    let folder = tempfile::tempdir().unwrap();
    Browser::new().file_is_in_order("compare", &page_of(&lab(), &folder, &small(&folder)), 1);
}

/// A comparison of a few methods on few engines.
fn small(folder: &TempDir) -> String {
    let output = Command::new(lab()).args(["compare", "--print-config"]).output().unwrap();
    let mut config: toml::Table = String::from_utf8(output.stdout).unwrap().parse().unwrap();
    for list in ["generators", "biases", "detectors", "scenarios"] {
        if let Some(toml::Value::Array(all)) = config.get_mut(list) {
            all.truncate(3);
        }
    }
    fs::write(folder.path().join("compare.toml"), config.to_string()).unwrap();
    "compare --config compare.toml --seeds 5".to_owned()
}

/// Units with alarms, one of a long name, and one that asks.
#[test]
#[ignore = "needs chromium"]
fn in_chromium_the_live_page_is_in_order() {
    let plant = Plant::new();
    let long =
        "a-pump-with-a-name-that-nobody-would-type-twice-but-somebody-has-typed-once-into-a-table";
    let stream = Plant::stream(600).replace("\"u2\"", &format!("\"{long}\""));
    let mut child = plant
        .command("watch --model model.toml --spec spec.toml --healthy healthy.csv --unit rig --http 127.0.0.1:0")
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let mut said = String::new();
    BufReader::new(child.stderr.take().unwrap()).read_line(&mut said).unwrap();
    let address =
        said.trim().strip_prefix("live page: http://").unwrap().trim_end_matches('/').to_owned();
    let mut stdin = child.stdin.take().unwrap();
    stdin.write_all(stream.as_bytes()).unwrap();
    stdin.flush().unwrap();
    // The next look shows what there is.
    std::thread::sleep(std::time::Duration::from_secs(3));
    Browser::live_is_in_order("watch", &address, 3);
    child.kill().unwrap();
    child.wait().unwrap();
}
