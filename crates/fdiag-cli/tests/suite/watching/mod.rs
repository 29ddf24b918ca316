//! A folder with a model, a healthy log and a stream of three units, and the real binary in it.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    dead_code,
    unreachable_pub,
    reason = "shared by several tests"
)]

#[cfg(feature = "mqtt")]
pub mod broker;
#[cfg(feature = "mqtt")]
pub mod ears;
#[cfg(feature = "mqtt")]
pub mod imposter;
#[cfg(feature = "mqtt")]
pub mod week;

use std::{
    collections::BTreeMap,
    fs,
    io::Write,
    path::PathBuf,
    process::{Child, Command, Output, Stdio},
};

use crate::support::{input, plant, run};
use fdiag::{
    log::write_log,
    model::{Channel, Record},
};
use tempfile::TempDir;

pub const MODEL: &str = r#"
version = 1
kind = "state-space"
name = "small turbine"
sample_time = 0.1
inputs = [{ name = "fuel", unit = "kg/s" }]
outputs = [{ name = "speed", unit = "rpm" }, { name = "temperature", unit = "K" }]

[matrices]
A = [[0.90, 0.06], [-0.04, 0.83]]
B = [[0.06], [0.11]]
C = [[1.0, 0.0], [0.3, 1.0]]
"#;

pub const SPEC: &str = r#"
hold_missing = 3
bias.orders = { kind = "fixed", na = 2, nb = 3 }
detector = { kind = "maximum", margin = 0.5 }
rule = { raise = 3, out_of = 3, clear = 5 }
isolation = { kind = "nearest", faults = "sensors" }
"#;

pub struct Plant {
    pub folder: TempDir,
}

fn record(samples: usize, variant: u32) -> Record {
    let run = run(&plant(), &input(samples, variant), 1e-3, u64::from(variant));
    let outputs = vec![Channel::new("speed", "rpm"), Channel::new("temperature", "K")];
    Record::from_rows(vec![Channel::new("fuel", "kg/s")], outputs, run.samples(), run.ts()).unwrap()
}

impl Plant {
    pub fn new() -> Self {
        let plant = Self { folder: tempfile::tempdir().unwrap() };
        fs::write(plant.path("model.toml"), MODEL).unwrap();
        fs::write(plant.path("spec.toml"), SPEC).unwrap();
        write_log(plant.path("healthy.csv"), &record(2000, 0)).unwrap();
        plant
    }

    /// A healthy run.
    pub fn run_of(samples: usize, variant: u32) -> Record {
        record(samples, variant)
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Three units, each with a fault of its own every 15 s or so, and a stream that is not always well.
    pub fn stream(samples: usize) -> String {
        let mut runs: Vec<Record> = (0..3).map(|unit| record(samples, 10 + unit)).collect();
        for (unit, run) in runs.iter_mut().enumerate() {
            for k in (0..samples).filter(|k| (k + 40 * unit) % 150 > 110) {
                run.y_mut(k)[unit % 2] += 0.1;
            }
        }
        let mut lines = String::new();
        for k in 0..samples {
            for (unit, run) in runs.iter().enumerate() {
                let (u, y) = (run.u(k)[0], run.y(k));
                let row = |k: usize| {
                    format!(
                        "{{\"rig\":\"u{unit}\",\"time\":{},\"fuel\":{u},\"speed\":{},\"temperature\":{}}}\n",
                        0.1 * k as f64,
                        y[0],
                        y[1]
                    )
                };
                match (k + 7 * unit) % 331 {
                    // A hole that is bridged, one that is not, a doubled and a late sample, a wrong clock.
                    100 | 200..215 => {}
                    250 => lines.push_str(&row(k).repeat(2)),
                    260 => lines.push_str(&(row(k) + &row(k.saturating_sub(2)))),
                    270 => lines.push_str(&(row(k + 100_000) + &row(k))),
                    _ => lines.push_str(&row(k)),
                }
            }
        }
        lines
    }

    pub fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fdiag"));
        command.args(line.split_whitespace()).current_dir(self.folder.path());
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// Runs a command with this on its standard input.
    pub fn run(&self, line: &str, stdin: &str) -> Output {
        let mut child = self.command(line).spawn().unwrap();
        let mut pipe = child.stdin.take().unwrap();
        std::thread::scope(|scope| {
            // Beside the reading: an answer may be longer than a pipe. A command that stops early does not read all.
            scope.spawn(move || drop(pipe.write_all(stdin.as_bytes())));
            child.wait_with_output().unwrap()
        })
    }

    pub fn spawn(&self, line: &str) -> Child {
        self.command(line).spawn().unwrap()
    }
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// What was promised in an output, by what makes it one; `Err` when the same key says two things.
pub fn promised(stdout: &str, into: &mut BTreeMap<String, String>) -> Result<(), String> {
    // The last line of a monitor that was killed may be cut off.
    for line in stdout.split_inclusive('\n').filter(|line| line.ends_with('\n')) {
        let message: fd_watch::Message =
            serde_json::from_str(line).map_err(|e| format!("{e}: {line}"))?;
        if let Some(key) = message.key()
            && let Some(before) = into.insert(key, line.to_owned())
            && before != line
        {
            return Err(format!("{before}{line}"));
        }
    }
    Ok(())
}
