//! `fdiag demo`: both halves on one page, and the files from which the commands on the page repeat them.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use std::{fs, path::Path, process::Command};

#[test]
fn both_halves_are_on_one_page_and_can_be_repeated() {
    let folder = tempfile::tempdir().unwrap();
    let fdiag = |line: &str, directory: &Path| {
        let output = Command::new(env!("CARGO_BIN_EXE_fdiag"))
            .args(line.split_whitespace())
            .current_dir(directory)
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let said = fdiag("demo --quiet --out out", folder.path());
    assert!(said.contains("no alarm without compensation, an alarm at"), "{said}");
    assert!(said.contains("Coulomb friction"), "{said}");
    let report = fs::read_to_string(folder.path().join("out/report.json")).unwrap();
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    // The fault begins at 10 s.
    let today = report["compensation"]["logs"].as_array().unwrap().last().unwrap();
    assert!(today["first_alarm_s"][0].is_null(), "{today}");
    let alarm = today["first_alarm_s"][1].as_f64().unwrap();
    assert!((10.0..15.0).contains(&alarm), "{alarm}");
    let page = fs::read_to_string(folder.path().join("out/report.html")).unwrap();
    assert!(page.matches("<svg").count() >= 4 && page.contains("engine/report.html"), "{page}");
    for half in ["engine", "cart"] {
        assert!(folder.path().join("out").join(half).join("report.html").exists(), "{half}");
    }
    let again = fdiag(
        "gap --model model.toml --log monday.csv --held-out friday.csv",
        &folder.path().join("out/cart"),
    );
    assert!(again.starts_with(report["gap"]["headline"].as_str().unwrap()), "{again}");
}

/// The files of the cart are those of the quick start.
#[test]
fn the_cart_is_that_of_the_quick_start() {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("demo/cart");
    let quick_start = own.join("../../../../examples/gap/quick-start");
    for file in ["model.toml", "monday.csv", "friday.csv"] {
        let read = |folder: &Path| fs::read_to_string(folder.join(file)).unwrap();
        assert_eq!(read(&own), read(&quick_start), "{file}");
    }
}
