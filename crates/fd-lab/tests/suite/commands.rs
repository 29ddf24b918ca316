//! The command line `fdiag-lab` as a user meets it: what it prints, writes and refuses.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use tempfile::TempDir;

/// A folder that commands run in.
struct Desk(TempDir);

impl Desk {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn put(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    fn text(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    fn lab(&self, line: &str) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fdiag-lab"));
        command.args(line.split_whitespace()).current_dir(self.0.path()).output().unwrap()
    }

    /// What a command that must succeed prints.
    #[track_caller]
    fn stdout(&self, line: &str) -> String {
        let output = self.lab(line);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    }

    /// Runs a command that must fail with `code` and say all of `words`.
    #[track_caller]
    fn fails(&self, line: &str, code: i32, words: &[&str]) -> String {
        let output = self.lab(line);
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "`{line}`: {error}");
        for word in words {
            assert!(error.contains(word), "`{line}` should mention `{word}`: {error}");
        }
        assert!(error.len() < 2_000 && !error.contains("panicked"), "{error}");
        assert!(output.stdout.is_empty(), "`{line}` printed a result");
        error
    }

    /// The same, and nothing is left behind.
    #[track_caller]
    fn refuses(&self, line: &str, code: i32, words: &[&str]) {
        let before = self.files();
        self.fails(line, code, words);
        assert_eq!(self.files(), before, "`{line}` left something behind");
    }

    fn files(&self) -> Vec<PathBuf> {
        let mut files = Vec::new();
        collect(self.0.path(), &mut files);
        files.sort();
        files
    }
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(&path, files);
        }
        files.push(path);
    }
}

#[test]
fn help_is_worth_reading() {
    let desk = Desk::new();
    for line in ["--help", ""] {
        let help = desk.stdout(line);
        assert!(["engine", "compare", "blind"].iter().all(|word| help.contains(word)), "{help}");
    }
    desk.refuses("engines", 2, &["engine"]);
    desk.refuses("engine --sedes 3", 2, &["--seeds"]);
    let man = desk.path("man1");
    desk.stdout(&format!("man {}", man.display()));
    assert!(desk.text("man1/fdiag-lab-blind-run.1").contains("time\\-limit"));
    assert!(desk.stdout("completions bash").contains("fdiag-lab"));
}

#[test]
fn the_engine_benchmark_writes_its_report() {
    let desk = Desk::new();
    let output = desk.lab("engine --seeds 2 --out report");
    let table = String::from_utf8_lossy(&output.stdout);
    assert!(table.contains("T_7") && table.contains("P_6"), "{table}");
    // No progress, no colours when piped.
    assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(!table.contains('\u{1b}'));

    let json: serde_json::Value = serde_json::from_str(&desk.text("report/report.json")).unwrap();
    assert_eq!(json["trials"].as_array().unwrap().len(), 2);
    let html = desk.text("report/report.html");
    assert!(html.starts_with("<!DOCTYPE html>") && html.trim_end().ends_with("</html>"));
    for outside in ["src=\"http", "href=\"http", "<script src", "@import"] {
        assert!(!html.contains(outside), "the report loads something: {outside}");
    }
    let svgs: Vec<PathBuf> =
        desk.files().into_iter().filter(|f| f.extension().is_some_and(|e| e == "svg")).collect();
    assert!(svgs.len() >= 5, "{svgs:?}");
    for svg in svgs {
        let text = fs::read_to_string(&svg).unwrap();
        assert!(text.contains("<svg") && text.trim_end().ends_with("</svg>"), "{}", svg.display());
    }

    // As JSON, on another number of threads: the same numbers.
    let printed = desk.stdout("engine --seeds 2 --out other --json --threads 1");
    let printed: serde_json::Value = serde_json::from_str(&printed).unwrap();
    assert_eq!(printed, json);
}

#[test]
fn what_it_prints_as_configuration_it_reads() {
    let desk = Desk::new();
    let config = desk.stdout("engine --seeds 2 --print-config");
    desk.put("config.toml", &config);
    assert_eq!(desk.stdout("engine --config config.toml --print-config"), config);
    assert!(!desk.path("fdiag-report").exists());
}

#[test]
fn wrong_settings_are_refused_with_the_known_ones() {
    let desk = Desk::new();
    desk.refuses("engine --config gone.toml", 3, &["gone.toml"]);
    desk.put("config.toml", "[fault]\nsize = 3\n");
    desk.refuses("engine --config config.toml", 3, &["`fault`", "`faults`", "line 1"]);
    desk.put("config.toml", "version = 7\n");
    desk.refuses("engine --config config.toml", 3, &["version 7", "version 1"]);
    desk.put("config.toml", "[faults]\nsensors = [\"T_9\"]\n");
    desk.refuses("engine --config config.toml", 3, &["T_9", "T_7", "P_6"]);
    desk.put("config.toml", "test_runs = 0\n");
    desk.refuses("engine --config config.toml", 3, &["test_runs", "at least 1"]);
    desk.refuses("engine --seeds 0", 2, &["--seeds"]);
    desk.refuses("engine --time-limit 10", 2, &["`10min`"]);
    #[cfg(target_os = "linux")]
    for command in ["engine", "compare"] {
        desk.refuses(&format!("{command} --config /dev/zero"), 3, &["(limit `bytes`)"]);
    }
}

#[test]
fn results_that_cannot_be_written_are_code_5() {
    let desk = Desk::new();
    desk.put("taken", "not a folder");
    desk.refuses("engine --seeds 1 --out taken", 5, &["taken"]);
    desk.refuses("engine --seeds 1 --out taken/below", 5, &["taken"]);
    assert_eq!(desk.text("taken"), "not a folder");
}

#[test]
fn a_broken_journal_is_bad_input_not_a_defect() {
    let desk = Desk::new();
    fs::create_dir(desk.path("out")).unwrap();
    desk.put("out/progress.jsonl", "no line of ours\n");
    desk.refuses("compare --out out", 3, &["progress.jsonl", "line 1"]);
    fs::create_dir(desk.path("cases")).unwrap();
    desk.put("cases/answers.jsonl", "no line of ours\n");
    desk.refuses("blind run cases", 3, &["answers.jsonl", "line 1"]);
}

#[test]
fn numbers_beyond_every_machine_are_refused() {
    let desk = Desk::new();
    let most = u64::MAX;
    desk.refuses(&format!("engine --seeds {most} --out made"), 4, &["seeds", "limit `cases`"]);
    let words = ["engines.", "limit `cases`"];
    desk.refuses(&format!("compare --seeds {most} --out made"), 4, &words);
    let make = "blind make --out made --seed 1 --single";
    let words = ["samples: expected at least 100", "found 0"];
    desk.refuses(&format!("{make} 1 --samples 0"), 4, &words);
    desk.refuses(&format!("{make} 1 --samples {most}"), 4, &["limit `samples`"]);
    desk.refuses(&format!("{make} {most} --none {most}"), 4, &["limit `cases`"]);
    desk.refuses(&format!("{make} 0"), 4, &["expected at least 1 case"]);
}

/// What would take hours is begun, looked at, and not gone on with.
#[test]
fn what_is_merely_large_has_to_be_wanted() {
    let desk = Desk::new();
    // Hours for some cases, and gigabytes for one; nothing is made before somebody wants it.
    let make = "blind make --out made --seed 1 --threads 1 --quick-oracle --none";
    let words = ["cases of 1000 samples: about", " h", "go on with --yes"];
    desk.refuses(&format!("{make} 100000"), 4, &words);
    desk.refuses(&format!("{make} 1 --samples 9000000"), 4, &["GB", "go on with --yes"]);
    let words = ["more engines: about", "go on with --yes"];
    desk.refuses("engine --seeds 100000 --threads 1 --out large", 4, &words);
    let words = ["go on with --yes (", "are finished and kept in"];
    let compare = "compare --scenario linear --seeds 20000 --threads 1 --out large";
    let said = desk.fails(compare, 4, &words);
    // Nothing of it is lost: what it says is there, below a line with what was asked.
    let (_, finished) = said.rsplit_once('(').unwrap();
    let finished: usize = finished.split_once(' ').unwrap().0.parse().unwrap();
    assert_eq!(desk.text("large/progress.jsonl").lines().count(), 1 + finished);
}

#[test]
fn a_time_limit_ends_it_with_what_there_is() {
    let desk = Desk::new();
    let text = desk.stdout("engine --seeds 50000 --time-limit 2s --quiet --out limited");
    assert!(
        text.starts_with("Stopped after ") && text.contains(" of 50000 engines; so far: "),
        "{text}"
    );
    let page = desk.text("limited/report.html");
    assert!(page.contains("of 50000 engines; so far: "), "the page does not say so");
    let words = ["stopped by the time limit of 1 s ("];
    desk.fails("compare --scenario linear --time-limit 1s --out later", 4, &words);
}
