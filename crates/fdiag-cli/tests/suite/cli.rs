//! The command line as a user meets it: what it prints, writes and refuses.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a failure here is a failed test; skips are printed"
)]

use std::{
    fmt::Write,
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use crate::support::{input, plant, run};
use fdiag::{
    log::write_log,
    model::{Channel, Record},
};
use tempfile::TempDir;

const MODEL: &str = r#"
version = 1
kind = "state-space"
name = "small turbine"
sample_time = 0.1

[[inputs]]
name = "fuel"
unit = "kg/s"

[[outputs]]
name = "speed"
unit = "rpm"

[[outputs]]
name = "temperature"
unit = "K"

[matrices]
A = [[0.90, 0.06], [-0.04, 0.83]]
B = [[0.06], [0.11]]
C = [[1.0, 0.0], [0.3, 1.0]]
"#;

/// A folder with a model, a healthy log and a later log whose second sensor fails at 60 s.
struct Desk {
    folder: TempDir,
}

impl Desk {
    fn new() -> Self {
        let desk = Self { folder: tempfile::tempdir().unwrap() };
        desk.put("model.toml", MODEL);
        write_log(desk.path("healthy.csv"), &log(&input(2000, 0), 1)).unwrap();
        let mut later = log(&input(1000, 4), 2);
        (600..1000).for_each(|k| later.y_mut(k)[1] += 0.1);
        write_log(desk.path("later.csv"), &later).unwrap();
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn put(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    fn text(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    fn fdiag(&self, line: &str) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fdiag"));
        command.args(line.split_whitespace()).current_dir(self.folder.path()).output().unwrap()
    }

    /// Runs a command that must fail with `code`, say all of `words` and leave nothing behind.
    fn refuses(&self, line: &str, code: i32, words: &[&str]) {
        let before = self.files();
        let output = self.fdiag(line);
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "`{line}`: {error}");
        for word in words {
            assert!(error.contains(word), "`{line}` should mention `{word}`: {error}");
        }
        assert!(!error.contains("panicked"), "{error}");
        assert!(output.stdout.is_empty(), "`{line}` printed a result");
        assert_eq!(self.files(), before, "`{line}` left something behind");
    }

    fn files(&self) -> Vec<PathBuf> {
        let mut files = Vec::new();
        collect(self.folder.path(), &mut files);
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

fn log(u: &[f64], seed: u64) -> Record {
    let record = run(&plant(), u, 1e-3, seed);
    let outputs = vec![Channel::new("speed", "rpm"), Channel::new("temperature", "K")];
    let y = record.samples().flat_map(|(_, y)| y.to_vec()).collect();
    let ts = record.ts();
    Record::new(vec![Channel::new("fuel", "kg/s")], outputs, u.to_vec(), y, ts).unwrap()
}

fn stdout(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout.clone()).unwrap()
}

#[test]
fn help_is_worth_reading() {
    let desk = Desk::new();
    let help = stdout(&desk.fdiag("--help"));
    for word in ["demo", "compensate", "Exit codes", "Patton & Chen"] {
        assert!(help.contains(word), "{help}");
    }
    for code in 0..=5 {
        assert!(help.contains(&format!("  {code}  ")), "{help}");
    }
    let help = stdout(&desk.fdiag("compensate --help"));
    for word in ["--model", "--log", "--healthy", "--columns", "--spec", "--json", "--out"] {
        assert!(help.contains(word), "{help}");
    }
    // Who asks for nothing gets the short help, and is told how to start.
    let before = desk.files();
    let alone = stdout(&desk.fdiag(""));
    assert!(alone.contains("Usage: fdiag") && alone.contains("\n  gap "), "{alone}");
    let last = alone.trim_end().lines().last().unwrap();
    assert!(last.starts_with("To start: `fdiag demo`") && last.contains("gap --help"), "{last}");
    assert_eq!(desk.files(), before, "nothing is run");
    assert!(stdout(&desk.fdiag("--version")).starts_with("fdiag "));
    desk.refuses("demos", 2, &["demo"]);
    desk.refuses("gap --hold-out 3", 2, &["--held-out"]);
    desk.refuses("compensate --model model.toml", 2, &["--log"]);
}

#[test]
fn what_it_prints_as_configuration_it_reads() {
    let desk = Desk::new();
    let line = "compensate --model model.toml --print-spec";
    let spec = stdout(&desk.fdiag(line));
    assert!(spec.starts_with("# settle_s = "), "{spec}");
    desk.put("spec.toml", &spec);
    assert_eq!(stdout(&desk.fdiag(&format!("{line} --spec spec.toml"))), spec);
    assert!(!desk.path("fdiag-report").exists());
}

#[test]
fn a_faulty_log_raises_an_alarm() {
    let desk = Desk::new();
    // A short healthy log does not show the largest residual that there will ever be.
    desk.put(
        "spec.toml",
        "bias.orders = { kind = \"fixed\", na = 3, nb = 4 }\ndetector = { kind = \"maximum\", margin = 0.5 }\n",
    );
    let line = "compensate --model model.toml --log healthy.csv --log later.csv --spec spec.toml --out report";
    let output = desk.fdiag(line);
    let table = stdout(&output);
    assert!(
        table.contains("later.csv") && table.contains("The later log raises an alarm."),
        "{table}"
    );
    assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
    let json: serde_json::Value = serde_json::from_str(&desk.text("report/report.json")).unwrap();
    let first = json["logs"][1]["first_alarm_s"][1].as_f64().unwrap();
    assert!((60.0..61.0).contains(&first), "{first}");

    let output = desk.fdiag(&format!("{line} --json --fail-on-alarm"));
    assert_eq!(output.status.code(), Some(1));
    let printed: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(printed, json);
    // The healthy log alone raises none.
    let output = desk.fdiag("compensate --model model.toml --log healthy.csv --fail-on-alarm");
    assert_eq!(output.status.code(), Some(0));
}

const COMPENSATE: &str = "compensate --model model.toml --out deep/report --log";

#[test]
fn wrong_files_are_refused_with_the_place() {
    let desk = Desk::new();
    let healthy = desk.text("healthy.csv");
    desk.refuses("compensate --model gone.toml --log healthy.csv", 3, &["gone.toml"]);
    desk.refuses(&format!("{COMPENSATE} gone.csv"), 3, &["gone.csv"]);
    desk.refuses(&format!("{COMPENSATE} healthy.csv --spec gone.toml"), 3, &["gone.toml"]);

    desk.put("broken.csv", &healthy.replacen("\n0.1,", "\n0.1,abc", 1));
    desk.refuses(&format!("{COMPENSATE} broken.csv"), 3, &["broken.csv", "`fuel", "row 4", "abc"]);

    desk.put("columns.csv", &healthy.replacen("temperature", "temprature", 1));
    let words = ["columns.csv", "`temperature", "did you mean", "fuel", "speed", "temprature"];
    desk.refuses(&format!("{COMPENSATE} columns.csv"), 3, &words);

    desk.put("units.csv", &healthy.replacen("[K]", "[kg]", 1));
    desk.refuses(&format!("{COMPENSATE} units.csv"), 3, &["units.csv", "temperature", "K", "kg"]);

    desk.put("empty.csv", "");
    desk.refuses(&format!("{COMPENSATE} empty.csv"), 3, &["empty.csv", "empty file"]);
    let header: Vec<&str> = healthy.lines().take(2).collect();
    desk.put("header.csv", &format!("{}\n", header.join("\n")));
    desk.refuses(&format!("{COMPENSATE} header.csv"), 3, &["header.csv", "rows"]);

    desk.put("time.csv", &healthy.replacen("\n0.5,", "\n0.05,", 1));
    desk.refuses(&format!("{COMPENSATE} time.csv"), 3, &["time.csv", "row 8", "0.05"]);

    desk.put("unstable.toml", &MODEL.replace("0.90", "1.90"));
    let words = ["unstable.toml", "not stable", "allow_unstable"];
    desk.refuses("compensate --model unstable.toml --log healthy.csv", 3, &words);
    desk.put("shape.toml", &MODEL.replace("[[0.06], [0.11]]", "[[0.06]]"));
    desk.refuses(
        "compensate --model shape.toml --log healthy.csv",
        3,
        &["shape.toml", "`matrices.B`", "2 rows"],
    );
    desk.put("key.toml", &MODEL.replace("sample_time", "sampletime"));
    let words = ["key.toml", "sampletime", "sample_time", "line 5"];
    desk.refuses("compensate --model key.toml --log healthy.csv", 3, &words);
}

#[test]
fn wrong_settings_are_refused_with_the_known_ones() {
    let desk = Desk::new();
    desk.put("spec.toml", "[generator]\nkind = \"obsrver\"\nrate = 2\n");
    let words = ["spec.toml", "line 2", "obsrver", "simulation", "observer", "kalman", "parity"];
    desk.refuses(&format!("{COMPENSATE} healthy.csv --spec spec.toml"), 3, &words);
    desk.put("spec.toml", "hold = 3\n");
    let words = ["`hold`", "hold_missing", "weighting", "settle_s"];
    desk.refuses(&format!("{COMPENSATE} healthy.csv --spec spec.toml"), 3, &words);
}

#[test]
fn data_that_do_not_allow_it_are_refused_with_the_reason() {
    let desk = Desk::new();
    write_log(desk.path("still.csv"), &log(&[0.3; 500], 1)).unwrap();
    desk.refuses(&format!("{COMPENSATE} still.csv"), 4, &["no input moves", "learned"]);
    write_log(desk.path("short.csv"), &log(&input(12, 0), 1)).unwrap();
    let words = ["learning the bias", "complete samples, found 8"];
    desk.refuses(&format!("{COMPENSATE} short.csv"), 4, &words);
    desk.put("spec.toml", "settle_s = -1.0\n");
    desk.refuses(&format!("{COMPENSATE} healthy.csv --spec spec.toml"), 4, &["settle_s", "-1"]);
    // A measurement without noise has a singular covariance.
    desk.put(
        "spec.toml",
        "generator = { kind = \"kalman\", process_noise = 1.0, output_noise = 0.0 }\n",
    );
    desk.refuses(&format!("{COMPENSATE} healthy.csv --spec spec.toml"), 4, &["covariance R"]);
    desk.put("spec.toml", "weighting = [[1.0, 1.0, 1.0]]\n");
    desk.refuses(&format!("{COMPENSATE} healthy.csv --spec spec.toml"), 4, &["weighting W", "1x2"]);
    // Recursive learning that is never satisfied.
    desk.put(
        "spec.toml",
        "bias.learning = { kind = \"recursive\" }\ncompensation.convergence.tolerance = 1e-12\n",
    );
    let words = ["did not converge", "compensation.convergence"];
    desk.refuses(&format!("{COMPENSATE} healthy.csv --spec spec.toml"), 4, &words);
    desk.refuses(&format!("{COMPENSATE} healthy.csv --learn-share 1.0"), 2, &["--learn-share"]);
    desk.refuses(&format!("{COMPENSATE} healthy.csv --learn-share NaN"), 2, &["--learn-share"]);
}

/// Missing cells are a stated policy: refused by default and counted, or held.
#[test]
fn missing_cells_are_left_out_and_counted() {
    let desk = Desk::new();
    let later = desk.text("later.csv");
    let mut lines: Vec<String> = later.lines().map(str::to_owned).collect();
    for line in &mut lines[100..110] {
        let cut = line.rfind(',').unwrap();
        line.replace_range(cut + 1.., "NaN");
    }
    desk.put("gaps.csv", &(lines.join("\n") + "\n"));
    let line = "compensate --model model.toml --log healthy.csv gaps.csv later.csv --json";
    let json: serde_json::Value = serde_json::from_str(&stdout(&desk.fdiag(line))).unwrap();
    assert_eq!(json["logs"][1]["refused"], 10);
    // Behind so long a gap it settles again before it judges.
    let judged = [1, 2].map(|log| json["logs"][log]["judged"].as_u64().unwrap());
    assert!(judged[0] + 10 < judged[1], "{judged:?}");
    desk.put("spec.toml", "hold_missing = 4\n");
    let line = format!("{line} --spec spec.toml");
    let json: serde_json::Value = serde_json::from_str(&stdout(&desk.fdiag(&line))).unwrap();
    assert_eq!(json["logs"][1]["refused"], 6);
}

/// An uneven time base is put on an even one, and the report says so.
#[test]
fn an_uneven_time_base_is_resampled_and_reported() {
    let desk = Desk::new();
    let healthy = desk.text("healthy.csv");
    let mut uneven = String::new();
    for (i, line) in healthy.lines().filter(|l| !l.starts_with('#')).enumerate() {
        match line.split_once(',') {
            Some((time, rest)) if i > 0 => {
                let time: f64 = time.parse().unwrap();
                let moved = time + 0.03 * ((i % 3) as f64 - 1.0);
                writeln!(uneven, "{moved:.3},{rest}").unwrap();
            }
            _ => writeln!(uneven, "{line}").unwrap(),
        }
    }
    desk.put("uneven.csv", &uneven);
    let line = "compensate --model model.toml --log uneven.csv --json";
    let json: serde_json::Value = serde_json::from_str(&stdout(&desk.fdiag(line))).unwrap();
    assert_eq!(json["logs"][0]["time_base"]["even"], false);
    assert!(json["logs"][0]["time_base"]["jitter_s"].as_f64().unwrap() > 0.01);
    assert!(desk.text("fdiag-report/report.html").contains("uneven time base"));
}

#[test]
fn results_that_cannot_be_written_are_code_5() {
    let desk = Desk::new();
    desk.put("taken", "not a folder");
    let line = "compensate --model model.toml --log healthy.csv --out taken";
    desk.refuses(line, 5, &["taken"]);
    desk.refuses(&format!("{line}/below"), 5, &["taken"]);
    assert_eq!(desk.text("taken"), "not a folder");
    // A folder that is there and takes no file, not even from the superuser.
    #[cfg(target_os = "linux")]
    desk.refuses("compensate --model model.toml --log healthy.csv --out /proc", 5, &["/proc"]);
}
