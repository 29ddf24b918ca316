//! `fdiag gap` as a user meets it: what it says, writes and refuses.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use serde_json::Value;
use tempfile::TempDir;

fn example(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/gap/quick-start").join(file)
}

/// A folder with a model and two logs of the quick start, to be spoiled.
struct Desk {
    folder: TempDir,
}

impl Desk {
    fn new() -> Self {
        let desk = Self { folder: tempfile::tempdir().unwrap() };
        for file in ["model.toml", "monday.csv", "friday.csv"] {
            fs::copy(example(file), desk.path(file)).unwrap();
        }
        desk
    }

    fn path(&self, file: &str) -> PathBuf {
        self.folder.path().join(file)
    }

    fn read(&self, file: &str) -> String {
        fs::read_to_string(self.path(file)).unwrap()
    }

    fn put(&self, file: &str, content: &str) {
        fs::write(self.path(file), content).unwrap();
    }

    /// Changes the rows of a log: number of the row from 0, and its cells.
    fn spoil(&self, file: &str, change: impl Fn(usize, &mut Vec<String>)) {
        let text = self.read(file);
        let mut row = 0;
        let mut spoiled = String::new();
        for line in text.lines() {
            if line.starts_with('#') {
                continue; // the line that states the sample time exactly
            }
            let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
            if !line.starts_with("time") {
                change(row, &mut cells);
                row += 1;
            }
            if !cells.is_empty() {
                spoiled.push_str(&cells.join(","));
                spoiled.push('\n');
            }
        }
        self.put(file, &spoiled);
    }

    fn run(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fdiag"));
        command.current_dir(self.folder.path()).arg("gap").args(arguments).output().unwrap()
    }

    /// Runs the plain command with more arguments.
    fn gap(&self, more: &[&str]) -> Output {
        let plain = ["--model", "model.toml", "--log", "monday.csv", "--out", "out"];
        self.run(&[&plain, more].concat())
    }

    fn report(&self) -> Value {
        serde_json::from_str(&self.read("out/report.json")).unwrap()
    }
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// Asserts an exit code and that the message has all of these parts; and that nothing was left.
#[track_caller]
fn refuses(desk: &Desk, output: &Output, code: i32, parts: &[&str]) {
    let message = String::from_utf8(output.stderr.clone()).unwrap();
    assert_eq!(output.status.code(), Some(code), "{message}");
    for part in parts {
        assert!(message.contains(part), "`{part}` is not in: {message}");
    }
    assert!(!desk.path("out").exists(), "something was written");
}

/// Only these effects, where a test is not about the answer.
const FEW: [&str; 4] = ["--only", "friction", "--only", "input-delay"];

#[test]
fn the_answer_is_one_sentence_and_tables() {
    let desk = Desk::new();
    let output = desk.gap(&["--held-out", "friday.csv"]);
    let text = stdout(&output);
    assert!(output.status.success(), "{output:?}");
    let headline = text.lines().next().unwrap();
    assert!(headline.starts_with("Coulomb friction at rail ("), "{headline}");
    for part in [" N", ", p ", "held-out data", "% ("] {
        assert!(headline.contains(part), "{headline}");
    }
    for title in ["Mechanism and place", "Cause", "How far, on held-out data"] {
        assert!(text.contains(title), "{text}");
    }
    assert!(output.stderr.is_empty(), "nothing is said to nobody: {output:?}");
    let page = desk.read("out/report.html");
    assert!(page.contains("<svg") && page.contains("Coulomb friction at rail"));
    let outside = ["<script", "href=", "src=", "@import", "url("];
    assert!(outside.iter().all(|o| !page.contains(o)), "the page needs something from elsewhere");
    let mut files: Vec<String> = fs::read_dir(desk.path("out"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    files.sort();
    assert_eq!(files, ["patched.toml", "report.html", "report.json"]);
    let report = desk.report();
    assert_eq!(report["version"], 1);
    assert_eq!(report["headline"], headline);
    assert_eq!(report["files"][1]["file"], "patched.toml");
}

#[test]
fn json_is_printed_as_it_is_written() {
    let desk = Desk::new();
    let printed = stdout(&desk.gap(&[&FEW[..], &["--json"]].concat()));
    assert_eq!(printed.trim_end(), desk.read("out/report.json").trim_end());
    // Without --held-out the last third of the log is held out.
    let logs = desk.report()["input"]["logs"].clone();
    assert_eq!((&logs[0]["samples"], &logs[0]["role"]), (&670.into(), &"fit".into()));
    assert_eq!((&logs[1]["samples"], &logs[1]["role"]), (&330.into(), &"held-out".into()));
    assert_eq!(logs[1]["from_s"], 6.7);
}

/// Same seed, same answer, whatever the number of threads.
#[test]
fn threads_change_nothing() {
    let desk = Desk::new();
    let mut reports = ["1", "2", "3"].map(|threads| {
        assert!(desk.gap(&["--threads", threads]).status.success());
        (desk.read("out/report.json"), desk.read("out/report.html"), desk.read("out/patched.toml"))
    });
    for (json, ..) in &mut reports {
        let timing = json.find("\"timing\"").unwrap();
        assert!(json[timing..].matches('{').count() == 1, "timing comes last");
        json.truncate(timing);
    }
    assert_eq!(reports[0], reports[1]);
    assert_eq!(reports[0], reports[2]);
}

/// The patched model is a model like any other, and before it is what after was.
#[test]
fn the_patched_model_closes_the_gap() {
    let desk = Desk::new();
    let held_out = ["--held-out", "friday.csv"];
    assert!(desk.gap(&held_out).status.success());
    let first = desk.report();
    let text = desk.read("out/patched.toml");
    assert!(text.starts_with("# Written by `fdiag gap`: the model with Coulomb friction at rail"));
    let plain = ["--model", "out/patched.toml", "--log", "monday.csv", "--out", "again"];
    let again = desk.run(&[&plain[..], &held_out].concat());
    assert!(again.status.success(), "{again:?}");
    let second: Value = serde_json::from_str(&desk.read("again/report.json")).unwrap();
    assert_eq!(second["verdict"], "no-gap");
    for (a, b) in [
        (
            &first["how_far"][0]["outputs"][0]["after"],
            &second["how_far"][0]["outputs"][0]["before"],
        ),
        (
            &first["location"]["channels"][0]["after"]["value"],
            &second["location"]["channels"][0]["before"]["value"],
        ),
    ] {
        let (Some(a), Some(b)) = (a.as_f64(), b.as_f64()) else {
            assert!(a.is_null() && b.is_null());
            continue;
        };
        // The same simulation, but for the initial state of the held-out run, which is estimated
        // from a part of it around another prior mean.
        assert!((a - b).abs() < 0.01 * a, "{a} {b}");
    }
}

/// Every key of a report is described.
#[test]
fn the_document_names_every_key() {
    fn keys(value: &Value, all: &mut BTreeSet<String>) {
        match value {
            Value::Object(map) => map.iter().for_each(|(key, value)| {
                all.insert(key.clone());
                keys(value, all);
            }),
            Value::Array(list) => list.iter().for_each(|value| keys(value, all)),
            _ => {}
        }
    }
    let desk = Desk::new();
    // A tie, so that advice is given; few candidates, to be quick.
    let only = ["--only", "input-gain", "--only", "parameter-error", "--calibrate", "1"];
    assert!(desk.gap(&only).status.success());
    let mut all = BTreeSet::new();
    keys(&desk.report(), &mut all);
    assert!(desk.gap(&[]).status.success());
    keys(&desk.report(), &mut all);
    let page = include_str!("../../../docs/gap-report.md");
    let missing: Vec<&String> =
        all.iter().filter(|key| !page.contains(&format!("`{key}`"))).collect();
    assert!(missing.is_empty(), "docs/gap-report.md does not name {missing:?}");
    assert!(60 < all.len(), "{}", all.len());
}

#[test]
fn what_the_user_knows_counts() {
    let desk = Desk::new();
    let known = ["--tolerance", "d=0", "--noise", "speed=0.005", "--exclude", "coulomb-friction"];
    let more = ["--exclude", "input-delay@force", "--horizon", "2", "--seed", "7"];
    assert!(desk.gap(&[&known[..], &more].concat()).status.success());
    let report = desk.report();
    let causes = report["causes"].as_array().unwrap();
    assert!(causes.iter().all(|c| c["label"] != "coulomb-friction" && c["label"] != "input-delay"));
    assert!(causes.iter().any(|c| c["label"] == "viscous-friction"));
    assert_eq!(report["noise"][0]["stated"], 0.005);
    assert!(report["parameters"].as_array().unwrap().iter().all(|p| p["name"] != "d"));
    let settings = &report["settings"];
    assert_eq!((&settings["horizon"], &settings["window_s"]), (&"windows".into(), &2.0.into()));
    assert_eq!((&settings["seed"], &settings["split"]), (&7.into(), &0.67.into()));
    assert_eq!(settings["horizon_from"], "stated");
    let model = stdout(&desk.gap(&["--print-model", "--tolerance", "m=0.5"]));
    assert!(model.contains("m = { unit = \"kg\", value = 1.2, tolerance = 0.5 }"), "{model}");
}

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
                    row[0] = "0.05".into()
                }
            })
        },
        3,
        &["column `time [s]`", "row 11", "after 0.08 s", "found 0.05 s"],
    );
    spoiled(
        &|desk| {
            desk.spoil("monday.csv", |k, row| {
                if k == 3 {
                    row[2] = "abc".into()
                }
            })
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
                    row.clear()
                }
            })
        },
        4,
        &["6 measured values", "at least 8"],
    );
    // The model forgets with m/d = 0.8 s.
    spoiled(
        &|desk| {
            desk.spoil("monday.csv", |k, row| {
                if 20 < k {
                    row.clear()
                }
            })
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
            row[0] = "0.05".into()
        }
    });
    let output = desk.gap(&[&FEW[..], &["--drop-disorder"]].concat());
    assert!(output.status.success(), "{output:?}");
    assert_eq!(desk.report()["input"]["logs"][0]["left_out"], 1);
}

/// A linear model has neither parameters with a meaning nor sites: it gets some.
#[test]
fn linear_models_are_diagnosed_as_well() {
    let desk = Desk::new();
    let head = "version = 1\nkind = \"state-space\"\nname = \"linear cart\"\n";
    let channels = "[[inputs]]\nname = \"force\"\nunit = \"N\"\n[[states]]\nname = \"v\"\nunit = \
                    \"m/s\"\n[[outputs]]\nname = \"speed\"\nunit = \"m/s\"\n[matrices]\n";
    let matrices = "A = [[-1.25]]\nB = [[0.8333]]\nC = [[1.0]]\n";
    desk.put("model.toml", &format!("{head}{channels}{matrices}"));
    let output = desk.gap(&["--held-out", "friday.csv"]);
    assert!(output.status.success(), "{output:?}");
    let report = desk.report();
    assert_eq!(
        (&report["input"]["model"], &report["input"]["sample_time_s"]),
        (&"linear cart".into(), &0.01.into())
    );
    let names: Vec<&str> = report["parameters"]
        .as_array()
        .unwrap()
        .iter()
        .map(|parameter| parameter["name"].as_str().unwrap())
        .collect();
    assert!(names.contains(&"time_scale") && names.contains(&"speed_gain"), "{names:?}");
    assert_eq!(report["groups"][0]["family"], "friction", "{}", report["headline"]);
    // A sampled model keeps its own pace.
    let matrices = "A = [[0.97531]]\nB = [[0.016461]]\nC = [[1.0]]\n";
    desk.put("model.toml", &format!("{head}sample_time = 0.02\n{channels}{matrices}"));
    assert!(desk.gap(&FEW).status.success());
    let input = desk.report()["input"].clone();
    assert_eq!(input["sample_time_s"], 0.02);
    assert!(input["policy"].as_str().unwrap().contains("pace of the model"), "{input}");
    // A mistake in it is one of the file.
    desk.put(
        "model.toml",
        &format!("{head}{channels}{}", matrices.replace("[[1.0]]", "[[1.0, 2.0]]")),
    );
    fs::remove_dir_all(desk.path("out")).unwrap();
    refuses(&desk, &desk.gap(&FEW), 3, &["model.toml", "matrices.C"]);
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
    assert!(text.starts_with("Check the log first: monday.csv, `speed`"), "{text}");
    assert!(text.contains("0.001") && !text.contains("Mechanism and place"), "{text}");
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
