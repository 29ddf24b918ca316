//! Requests that no machine could serve: each is refused within seconds, with what is allowed.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
    time::{Duration, Instant},
};

use crate::folder::Folder;

/// Nobody waits longer for a refusal, on however slow a machine.
const PATIENCE: Duration = Duration::from_secs(60);

struct Desk(Folder);

impl Desk {
    fn new() -> Self {
        Self(Folder::of(&[
            ("gap/quick-start/model.toml", "model.toml"),
            ("gap/quick-start/monday.csv", "monday.csv"),
        ]))
    }

    fn path(&self, file: &str) -> PathBuf {
        self.0.path(file)
    }

    fn refuses(&self, line: &str, code: i32, words: &[&str]) {
        let begun = Instant::now();
        let output = Command::new(env!("CARGO_BIN_EXE_fdiag"))
            .args(line.split_whitespace())
            .current_dir(self.0.root())
            .output()
            .unwrap();
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{line}: {text}");
        for word in words {
            assert!(text.contains(word), "{line}: `{word}` is not in: {text}");
        }
        assert!(text.len() < 2_000, "{line}: {} bytes", text.len());
        assert!(!text.contains('\u{1b}'), "{line}: {text:?}");
        assert!(begun.elapsed() < PATIENCE, "{line}: {:?}", begun.elapsed());
        let left = fs::read_dir(self.0.root()).unwrap().filter_map(Result::ok);
        let left: Vec<_> = left.map(|entry| entry.file_name()).collect();
        let is_made = |name: &&std::ffi::OsString| name.to_string_lossy().starts_with("made");
        assert!(!left.iter().any(|name| is_made(&name)), "{line}: {left:?}");
    }
}

const GAP: &str = "gap --model model.toml --log monday.csv --out made";

#[test]
fn numbers_beyond_every_machine_are_refused() {
    let desk = Desk::new();
    desk.refuses(&format!("{GAP} --threads 1000000000"), 4, &["--threads", "limit `threads`"]);
    desk.refuses(&format!("{GAP} --resample 1e-9"), 3, &["monday.csv", "limit `samples`"]);
    desk.refuses(&format!("{GAP} --calibrate 4000000000"), 4, &["--calibrate", "limit `models`"]);
}

#[test]
fn a_clock_that_jumps_is_told() {
    let desk = Desk::new();
    let log = fs::read_to_string(desk.path("monday.csv")).unwrap();
    let lines: Vec<&str> = log.lines().skip(1).collect();
    let jumped: Vec<String> = lines
        .iter()
        .enumerate()
        .map(|(i, line)| match line.split_once(',') {
            Some((t, rest)) if 500 < i => format!("{},{rest}", t.parse::<f64>().unwrap() + 1e6),
            _ => (*line).to_owned(),
        })
        .collect();
    fs::write(desk.path("monday.csv"), jumped.join("\n")).unwrap();
    desk.refuses(GAP, 3, &["monday.csv", "limit `samples`", "the longest without a sample"]);
}

#[test]
fn a_spec_is_refused_by_file_and_key() {
    let desk = Desk::new();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    for file in ["turbine.toml", "turbine-run.csv"] {
        fs::copy(root.join(file), desk.path(file)).unwrap();
    }
    let line = "compensate --model turbine.toml --log turbine-run.csv --spec spec.toml --out made";
    for (spec, words) in [
        ("[rule]\nraise = 3\nout_of = 100000\n", ["spec.toml", "rule.out_of", "limit `window`"]),
        (
            "[detector]\nkind = 'maximum'\nmargin = 'x'\n",
            ["spec.toml, line 3", "`detector.margin`", "string"],
        ),
        (
            "[bias]\norders = { kind = 'fixed', na = -2, nb = 1 }",
            ["spec.toml", "`bias.orders.na`", "-2"],
        ),
    ] {
        fs::write(desk.path("spec.toml"), spec).unwrap();
        desk.refuses(line, 3, &words);
    }
}

#[test]
fn what_a_terminal_would_obey_and_what_nobody_reads_is_not_echoed() {
    let desk = Desk::new();
    let model = fs::read_to_string(desk.path("model.toml")).unwrap();
    let long = "q".repeat(1_000_000);
    for (from, to) in [
        ("force - d*v", format!("force - d*v + {long}")),
        ("kind = \"equations\"", format!("kind = \"{long}\"")),
        ("kind = \"equations\"", "kind = \"\\u001b[31m\"".to_owned()),
        ("name = \"cart\"", "name = \"\\u001b[31m\"".to_owned()),
        ("version = 1", format!("version = 1\n{long} = 1")),
    ] {
        fs::write(desk.path("model.toml"), model.replacen(from, &to, 1)).unwrap();
        desk.refuses(GAP, 3, &["model.toml"]);
    }
    fs::write(desk.path("model.toml"), &model).unwrap();
    let log = fs::read_to_string(desk.path("monday.csv")).unwrap();
    for (from, to) in [
        ("speed [m/s]", long.clone()),
        ("speed [m/s]", "\"sp\u{1b}[31meed\"".to_owned()),
        ("1.496", format!("1.496{long}")),
    ] {
        fs::write(desk.path("monday.csv"), log.replacen(from, &to, 1)).unwrap();
        desk.refuses(GAP, 3, &["monday.csv"]);
    }
}
