//! What it refuses, and what it mends and says.

use std::fs;

use crate::desk::{Desk, FEW, refuses, stdout};

#[test]
fn wrong_settings_are_refused() {
    let desk = Desk::new();
    for (arguments, code, parts) in [
        (&["--tolerance", "mass=0.1"][..], 3, &["--tolerance", "`mass`", "`m`, `d`"][..]),
        (&["--noise", "position=1"], 3, &["--noise", "`position`", "`speed`"]),
        (&["--noise", "speed=0"], 3, &["--noise", "above 0", "speed=0"]),
        (&["--exclude", "coulom"], 3, &["--exclude", "`coulom`", "`coulomb-friction`"]),
        (&["--only", "friction@shaft"], 3, &["--only", "`shaft`", "`rail`"]),
        (&["--split", "1.5"], 2, &["--split", "between 0 and 1"]),
        (&["--horizon=-1"], 2, &["--horizon", "number of seconds above 0"]),
        (&["--tolerance", "m"], 2, &["NAME=VALUE"]),
        (&["--split", "0.5", "--held-out", "friday.csv"], 2, &["cannot be used with"]),
    ] {
        refuses(&desk, &desk.gap(arguments), code, parts);
    }
    refuses(&desk, &desk.run(&["--model", "model.toml"]), 2, &["--log <FILE>"]);
}

#[test]
fn wrong_models_are_refused() {
    let desk = Desk::new();
    let good = desk.read("model.toml");
    let broken = good.replace("(force - d*v)/m", "(force - d*)/m");
    desk.put("model.toml", &broken);
    let message = ["model.toml:17:61:", "states.v.derivative", "^"];
    refuses(&desk, &desk.gap(&[]), 3, &message);
    desk.put("model.toml", &good.replace("(force - d*v)/m", "(forc - d*v)/m"));
    refuses(&desk, &desk.gap(&[]), 3, &["`forc` is not known", "did you mean `force`?"]);
    desk.put("model.toml", &good.replace("\"equations\"", "\"neural-network\""));
    refuses(
        &desk,
        &desk.gap(&[]),
        3,
        &["model.toml", "`neural-network`", "expected `equations` or"],
    );
    desk.put("model.toml", "version = 1\nkind = equations\n");
    refuses(&desk, &desk.gap(&[]), 3, &["model.toml:2:"]);
    desk.put("model.toml", &good.replace("(force - d*v)/m", "(force - d*v + 1e9*v^3)/m"));
    refuses(&desk, &desk.gap(&[]), 4, &["diverges"]);
    fs::remove_file(desk.path("model.toml")).unwrap();
    refuses(&desk, &desk.gap(&[]), 3, &["model.toml"]);
}

#[test]
fn wrong_logs_are_refused() {
    let spoiled = |change: &dyn Fn(&Desk), code, parts: &[&str]| {
        let desk = Desk::new();
        change(&desk);
        refuses(&desk, &desk.gap(&FEW), code, parts);
    };
    let header = |from: &'static str, to: &'static str| {
        move |desk: &Desk| desk.put("monday.csv", &desk.read("monday.csv").replace(from, to))
    };
    spoiled(&header("speed [m/s]", "velocity [m/s]"), 3, &["no column `speed`", "velocity"]);
    spoiled(&header("speed [m/s]", "speed [N]"), 3, &["column `speed [N]`", "monday.csv", "m/s"]);
    spoiled(&|desk| desk.put("monday.csv", ""), 3, &["monday.csv", "empty file"]);
    spoiled(&header("time [s]", "when"), 3, &["expected a column `time`", "when"]);
    spoiled(
        &|desk| {
            desk.spoil("monday.csv", |k, row| {
                if k == 9 {
                    row[0] = "0.05".into();
                }
            });
        },
        3,
        &["column `time [s]`", "row 11", "after 0.08 s", "found 0.05 s"],
    );
    spoiled(
        &|desk| {
            desk.spoil("monday.csv", |k, row| {
                if k == 3 {
                    row[2] = "abc".into();
                }
            });
        },
        3,
        &["row 5", "finite number", "`abc`"],
    );
    for (column, role) in [(1, "input `force`"), (2, "output `speed`")] {
        spoiled(
            &|desk| desk.spoil("monday.csv", |_, row| row[column] = "NaN".into()),
            3,
            &["monday.csv", role, "found none in"],
        );
    }
    spoiled(
        &|desk| desk.spoil("monday.csv", |k, row| row[0] = (10 * k).to_string()),
        3,
        &["10 s apart", "0.01 s", "unit = \"ms\""],
    );
    spoiled(
        &|desk| {
            desk.spoil("monday.csv", |k, row| {
                if 5 < k {
                    row.clear();
                }
            });
        },
        4,
        &["6 measured values", "at least 8"],
    );
    // The model forgets with m/d = 0.8 s.
    spoiled(
        &|desk| {
            desk.spoil("monday.csv", |k, row| {
                if 20 < k {
                    row.clear();
                }
            });
        },
        4,
        &["monday.csv: it lasts 0.21 s", "remembers its initial state for 0.", "--horizon"],
    );
}

/// What can be mended is mended, and said.
#[test]
fn uneven_and_missing_samples_are_reported() {
    let desk = Desk::new();
    desk.spoil("monday.csv", |k, row| {
        let jitter = if k % 3 == 0 { 2e-4 } else { 0.0 };
        row[0] = format!("{}", k as f64 * 0.01 + jitter);
        if k % 50 == 7 {
            row[2] = String::new();
        }
        if (400..440).contains(&k) {
            row.clear();
        }
    });
    let output = desk.gap(&FEW);
    assert!(output.status.success(), "{output:?}");
    let report = desk.report();
    let log = &report["input"]["logs"][0];
    assert_eq!((&log["is_even"], &log["gaps"]), (&false.into(), &1.into()));
    assert!(0.05 < log["missing_share"].as_f64().unwrap(), "{log}");
    let kinds: Vec<&str> = report["findings"]
        .as_array()
        .unwrap()
        .iter()
        .map(|finding| finding["kind"].as_str().unwrap())
        .collect();
    assert!(kinds.contains(&"missing") && kinds.contains(&"uneven"), "{kinds:?}");
    // Disorder is dropped when the user says so.
    desk.spoil("monday.csv", |k, row| {
        if k == 9 {
            row[0] = "0.05".into();
        }
    });
    let output = desk.gap(&[&FEW[..], &["--drop-disorder"]].concat());
    assert!(output.status.success(), "{output:?}");
    assert_eq!(desk.report()["input"]["logs"][0]["left_out"], 1);
}

/// A log that is not what it claims to be gets a finding, not a cause.
#[test]
fn a_wrong_unit_is_found_instead_of_a_cause() {
    let desk = Desk::new();
    desk.spoil("monday.csv", |_, row| {
        row[2] = (1e3 * row[2].parse::<f64>().unwrap()).to_string();
    });
    let output = desk.gap(&FEW);
    let text = stdout(&output);
    assert!(output.status.success(), "{output:?}");
    // In a linear model a force in mN does the same as a speed in mm/s: both are named.
    assert!(text.starts_with("Check the log first: monday.csv"), "{text}");
    assert!(
        text.contains("speed") && text.contains("0.001") && !text.contains("Mechanism and place"),
        "{text}"
    );
}

/// Interrupted by a reader or by a directory that cannot be written, it leaves no half of a file.
#[test]
fn what_cannot_be_written_is_said() {
    let desk = Desk::new();
    desk.put("out", "a file, not a directory");
    let output = desk.gap(&FEW);
    assert_eq!(output.status.code(), Some(5));
    assert!(String::from_utf8_lossy(&output.stderr).contains("cannot write out"), "{output:?}");
    assert_eq!(desk.read("out"), "a file, not a directory");
}
