//! `--time-limit` and `--memory-limit`: every command ends by then, with a code of its own and nothing left behind.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use std::{
    fs,
    io::Write,
    path::PathBuf,
    process::{Command, Output, Stdio},
    time::{Duration, Instant},
};

use crate::folder::Folder;

struct Desk(Folder);

impl Desk {
    fn new() -> Self {
        Self(Folder::of_both())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path(name)
    }

    fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fdiag"));
        command.args(line.split_whitespace()).current_dir(self.0.root()).stdin(Stdio::null());
        command
    }

    #[track_caller]
    fn refuses(&self, line: &str, code: i32, words: &[&str]) -> Output {
        let output = self.command(line).output().unwrap();
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "`{line}`: {error}");
        for word in words {
            assert!(error.contains(word), "`{line}` should mention `{word}`: {error}");
        }
        output
    }
}

/// A program that says nothing for a minute, and starts another one that does not listen to its parent.
const SILENT: &str = "version = 1\nkind = \"process\"\n\
                      command = [\"sh\", \"-c\", \"sleep 61 & echo $! > pid; sleep 61\"]\ntimeout = 60\n";

#[test]
fn a_command_ends_when_its_time_is_over_and_leaves_nothing() {
    let desk = Desk::new();
    fs::write(desk.path("silent.toml"), SILENT).unwrap();
    for line in [
        "gap --time-limit 1s --model silent.toml --print-model",
        "--time-limit 1s simulator check silent.toml",
        "calibrate --model silent.toml --log monday.csv --time-limit 1s",
    ] {
        let begun = Instant::now();
        desk.refuses(line, 6, &["the time is over: --time-limit 1 s"]);
        assert!(begun.elapsed() < Duration::from_secs(30), "{line}");
        // What it has started is gone with it.
        let id = fs::read_to_string(desk.path("pid")).unwrap();
        let process = PathBuf::from(format!("/proc/{}/stat", id.trim()));
        let is_alive = || {
            let stat = fs::read_to_string(&process).unwrap_or_default();
            !stat.is_empty() && !stat.contains(") Z ")
        };
        for _ in 0..100 {
            if is_alive() {
                std::thread::sleep(Duration::from_millis(20));
            }
        }
        assert!(!is_alive(), "{line}");
        assert!(!desk.path("fdiag-report").exists(), "{line}");
    }
}

/// Much work, in which there is no simulator.
#[test]
fn a_study_of_logs_ends_as_well_and_its_directory_is_gone() {
    let desk = Desk::new();
    let row = |k| format!("{},{},{}\n", 0.1 * k, f64::sin(0.3 * k), f64::cos(0.2 * k));
    let rows: Vec<String> = (0..400_000).map(f64::from).map(row).collect();
    let log = format!("t,u,y\n{}", rows.concat());
    fs::write(desk.path("long.csv"), log).unwrap();
    let model = "version = 1\nkind = \"state-space\"\nname = \"lag\"\nsample_time = 0.1\n\
                 inputs = [{ name = \"u\", unit = \"1\" }]\noutputs = [{ name = \"y\", unit = \"1\" }]\n\
                 [matrices]\nA = [[0.9]]\nB = [[0.1]]\nC = [[1.0]]\n";
    fs::write(desk.path("lag.toml"), model).unwrap();
    let line = "compensate --model lag.toml --log long.csv --out made/deep --time-limit 0.3s";
    desk.refuses(line, 6, &["the time is over: --time-limit 0.3 s"]);
    assert!(!desk.path("made").exists());
}

#[test]
fn a_monitor_ends_in_order() {
    let desk = Desk::new();
    let line = "watch --model turbine.toml --healthy run.csv --state state --time-limit 2s";
    let mut child = desk
        .command(line)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // Its input does not end.
    let mut stdin = child.stdin.take().unwrap();
    stdin.write_all(b"\n").unwrap();
    let output = child.wait_with_output().unwrap();
    drop(stdin);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(6), "{error}");
    assert!(error.contains("the time is over: --time-limit 2 s"), "{error}");
}

#[test]
fn a_command_ends_when_it_takes_too_much_memory() {
    let desk = Desk::new();
    let rows: Vec<String> = (0..1_000_000).map(|k| format!("{k},1,2\n")).collect();
    let log = format!("t,u,y\n{}", rows.concat());
    fs::write(desk.path("long.csv"), log).unwrap();
    // What the file claims is refused by name, a quarter being little ...
    desk.refuses("log info long.csv --memory-limit 30MB", 3, &["long.csv: times of the log"]);
    // ... and what work takes besides is seen by whoever looks.
    let line = "gap --model model.toml --log monday.csv --memory-limit 3MB --out made";
    let words = ["of memory, more than --memory-limit 3 MB"];
    desk.refuses(line, 6, &words);
    assert!(!desk.path("made").exists());
    let output = desk.command("log info long.csv --memory-limit 500MB").output().unwrap();
    assert!(output.status.success(), "{output:?}");
}

#[test]
fn limits_without_a_unit_are_refused() {
    let desk = Desk::new();
    for line in [
        "log info run.csv --time-limit 10",
        "log info run.csv --memory-limit 10",
        "log info run.csv --memory-limit 1kB",
    ] {
        desk.refuses(line, 2, &["with its unit"]);
    }
}
