//! Rubbish, and places that take nothing: each is refused in words, nothing panics, and a terminal obeys nothing.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output, Stdio},
    time::{Duration, Instant},
};

use crate::folder::Folder;

/// Nobody waits longer for a refusal, on however slow a machine.
const PATIENCE: Duration = Duration::from_secs(60);

struct Desk(Folder);

impl Desk {
    fn new() -> Self {
        Self(Folder::of_both())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path(name)
    }

    /// A line of a shell with 4 GB of memory, in which `$F` is the program.
    fn shell(&self, line: &str) -> Output {
        let begun = Instant::now();
        let mut child = Command::new("sh")
            .args(["-c", &format!("ulimit -v 4000000; {line}")])
            .current_dir(self.0.root())
            .env("F", env!("CARGO_BIN_EXE_fdiag"))
            .env_remove("RUST_BACKTRACE")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        // Little is printed here: no pipe is ever full.
        while child.try_wait().unwrap().is_none() {
            if PATIENCE < begun.elapsed() {
                child.kill().unwrap();
                panic!("`{line}` takes longer than {PATIENCE:?}");
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        let output = child.wait_with_output().unwrap();
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(!error.contains("panicked"), "`{line}`: {error}");
        output
    }

    #[track_caller]
    fn refuses(&self, line: &str, code: i32, word: &str) {
        let output = self.shell(line);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "`{line}`: {error}");
        assert!(error.contains(word), "`{line}` should mention `{word}`: {error}");
        assert!(error.len() < 2000, "`{line}`: {} bytes", error.len());
    }
}

const GAP: &str = "$F gap --only input-delay";

#[test]
fn what_never_ends_is_refused() {
    let desk = Desk::new();
    for log in ["/dev/zero", "/dev/full", "/dev/urandom"] {
        desk.refuses(
            &format!("{GAP} --model model.toml --log {log} --out made"),
            3,
            "found a device",
        );
    }
    desk.refuses("$F log info /dev/zero", 3, "found a device");
    desk.refuses("$F watch --model turbine.toml --healthy /dev/zero", 3, "found a device");
    let limit = "(limit `bytes`)";
    for line in [
        "gap --model /dev/zero --log monday.csv --out made",
        "gap --model model.toml --log monday.csv --effects /dev/zero --out made",
        "gap --model model.toml --log monday.csv --columns /dev/zero --out made",
        "compensate --model turbine.toml --log run.csv --spec /dev/zero --out made",
        "simulator check /dev/zero",
        "simulator serve /dev/zero",
    ] {
        desk.refuses(&format!("$F {line}"), 3, limit);
    }
    desk.refuses("$F structure --model /dev/zero --out made", 3, "/dev/zero");
    desk.refuses("$F compensate --model /dev/zero --log run.csv --out made", 3, "/dev/zero");
    assert!(!desk.path("made").exists());
}

/// What prints much, or a settings file that a shell cuts off.
const PRINTING: [&str; 7] = [
    "gap --only input-delay --model model.toml --log monday.csv",
    "gap --only input-delay --model model.toml --log monday.csv --json",
    "gap --model model.toml --print-model",
    "compensate --model turbine.toml --log run.csv --print-spec",
    "completions zsh",
    "log info monday.csv",
    "structure --model model.toml",
];

#[test]
fn a_reader_that_has_seen_enough_is_no_failure_and_a_full_disk_is_one() {
    let desk = Desk::new();
    for line in PRINTING {
        // The reader is gone before the first word.
        let output =
            desk.shell(&format!("{{ sleep 0.2; $F {line}; echo $? > code; }} | true; sleep 0.1"));
        assert!(output.status.success(), "{line}: {output:?}");
        for _ in 0..100 {
            if desk.path("code").exists() {
                break;
            }
            std::thread::sleep(Duration::from_millis(100));
        }
        assert_eq!(fs::read_to_string(desk.path("code")).unwrap(), "0\n", "{line}");
        fs::remove_file(desk.path("code")).unwrap();
        desk.refuses(&format!("$F {line} > /dev/full"), 5, "standard output");
        let output = desk.shell(&format!("$F {line} > said 2> /dev/full"));
        assert!(output.status.success(), "{line}: {output:?}");
    }
    // What went wrong cannot be told, but the code says it.
    for (line, code) in [("gap --model gone.toml --log x.csv", 3), ("log --sedes 3", 2)] {
        let output = desk.shell(&format!("$F {line} 2> /dev/full"));
        assert_eq!(output.status.code(), Some(code), "{line}");
    }
}

#[test]
fn a_terminal_is_shown_everything_and_obeys_nothing() {
    let desk = Desk::new();
    let wild = "w\u{1b}[31m\nild.csv";
    fs::copy(desk.path("monday.csv"), desk.path(wild)).unwrap();
    fs::write(desk.path("column.csv"), "time,\"a\u{1b}[31mb\u{9b}1m\"\n0,1\n1,2\n2,3\n").unwrap();
    let lines = [
        "log info column.csv".to_owned(),
        format!("log info '{wild}'"),
        format!("gap --only input-delay --model model.toml --log '{wild}' --out made"),
        "simulator check -- printf '\\033[31m\\033]0;x\\007\\n'".to_owned(),
        format!("gap --model model.toml --log '{wild}' --noise '{wild}=1' --out made"),
        format!("watch --model turbine.toml --healthy '{wild}'"),
        format!("'{wild}'"),
    ];
    for line in lines {
        let output = desk.shell(&format!("$F {line}"));
        for said in [&output.stdout, &output.stderr] {
            let said = String::from_utf8_lossy(said);
            let is_wild = |c: char| c.is_control() && c != '\n' && c != '\t';
            assert!(!said.contains(is_wild), "{line}: {said:?}");
        }
        assert!(!output.stdout.is_empty() || !output.stderr.is_empty(), "{line} says nothing");
    }
    for file in ["made/report.html", "made/report.json"] {
        assert!(!fs::read_to_string(desk.path(file)).unwrap().contains('\u{1b}'), "{file}");
    }
}

/// Both write whole files, so what is there at the end is one of the two reports.
#[test]
fn two_runs_in_one_directory_leave_a_whole_report() {
    let desk = Desk::new();
    let run = format!("{GAP} --model model.toml --log monday.csv --out made");
    let output = desk.shell(&format!("{run} > one & {run} > two; wait $!"));
    assert!(output.status.success(), "{output:?}");
    let json = fs::read_to_string(desk.path("made/report.json")).unwrap();
    let report: serde_json::Value = serde_json::from_str(&json).unwrap();
    let headline = report["headline"].as_str().unwrap();
    assert!(fs::read_to_string(desk.path("one")).unwrap().contains(headline));
    let page = fs::read_to_string(desk.path("made/report.html")).unwrap();
    assert!(page.trim_end().ends_with("</html>"));
    let left = fs::read_dir(desk.path("made")).unwrap().map(|e| e.unwrap().file_name());
    let mut left: Vec<String> = left.map(|name| name.to_string_lossy().into_owned()).collect();
    left.sort();
    assert!(
        left.iter().all(|name| Path::new(name).extension().is_some_and(|e| e == "toml")
            || name.starts_with("report.")),
        "{left:?}"
    );
}

/// Names of people are not those of programmers.
#[test]
fn names_in_any_script_are_names() {
    let desk = Desk::new();
    let name = "сб 土曜 ünï 🚗.csv";
    fs::copy(desk.path("monday.csv"), desk.path(name)).unwrap();
    let output = desk.shell(&format!("{GAP} --model model.toml --log '{name}' --out 'отчёт 1'"));
    assert!(output.status.success(), "{output:?}");
    assert!(fs::read_to_string(desk.path("отчёт 1/report.html")).unwrap().contains(name));
    desk.refuses(&format!("{GAP} --model model.toml --log 'нет.csv'"), 3, "нет.csv");
}
