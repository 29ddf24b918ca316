//! A folder with the files that documented commands name.

use std::{
    fs,
    path::PathBuf,
    process::{Command, Output, Stdio},
    time::{Duration, Instant},
};

use tempfile::TempDir;

use fd_console::documented::root;

/// Nobody waits longer for a command that is documented as if it were quick, on however slow a machine.
const PATIENCE: Duration = Duration::from_secs(300);
/// How long a monitor that never ends is watched.
const WATCHED: Duration = Duration::from_secs(3);

pub(crate) struct Desk {
    folder: TempDir,
}

impl Desk {
    pub(crate) fn new() -> Self {
        let desk = Self { folder: tempfile::tempdir().unwrap() };
        let examples = root().join("examples").canonicalize().unwrap();
        std::os::unix::fs::symlink(&examples, desk.path("examples")).unwrap();
        let copy = |from: &str, to: &str| {
            fs::copy(examples.join(from), desk.path(to)).unwrap();
        };
        for log in ["monday.csv", "tuesday.csv"] {
            copy("gap/quick-start/monday.csv", log);
        }
        copy("gap/quick-start/friday.csv", "friday.csv");
        copy("gap/quick-start/model.toml", "cart.toml");
        copy("turbine.toml", "model.toml");
        for log in ["healthy.csv", "today.csv", "later.csv", "growing.csv"] {
            copy("turbine-run.csv", log);
        }
        fs::copy(root().join("crates/fd-log/tests/data/flight.ulg"), desk.path("flight.ulg"))
            .unwrap();
        desk.shell("gzip -k monday.csv");
        let samples = samples(&fs::read_to_string(desk.path("later.csv")).unwrap());
        fs::write(desk.path("samples.ndjson"), &samples).unwrap();
        // What stands for a broker.
        fs::create_dir(desk.path("bin")).unwrap();
        desk.script("mosquitto_sub", "cat samples.ndjson");
        desk.script("fdiag", &format!("exec {} \"$@\"", env!("CARGO_BIN_EXE_fdiag")));
        for folder in
            ["share/bash-completion/completions", "../.zfunc", "../.config/fish/completions"]
        {
            fs::create_dir_all(desk.path(".local").join(folder)).unwrap();
        }
        desk
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn script(&self, name: &str, text: &str) {
        use std::os::unix::fs::PermissionsExt;
        let path = self.path("bin").join(name);
        fs::write(&path, format!("#!/bin/sh\n{text}\n")).unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
    }

    fn sh(&self, line: &str) -> Command {
        let mut command = Command::new("sh");
        let path = std::env::var("PATH").unwrap_or_default();
        let path = format!("{}:{path}", self.path("bin").display());
        command.args(["-c", line]).current_dir(self.folder.path()).env("PATH", path);
        command.env("HOME", self.folder.path()).stdin(Stdio::null());
        command
    }

    fn shell(&self, line: &str) -> Output {
        let output = self.sh(line).output().unwrap();
        assert!(output.status.success(), "`{line}`: {}", String::from_utf8_lossy(&output.stderr));
        output
    }

    /// Runs a line of a shell, and says what went wrong.
    pub(crate) fn runs(&self, place: &str, line: &str) -> Result<(), String> {
        let is_endless = line.contains("--follow");
        let line = if is_endless { format!("exec {line}") } else { line.to_owned() };
        let begun = Instant::now();
        let mut child =
            self.sh(&line).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        if is_endless {
            std::thread::sleep(WATCHED);
            if child.try_wait().unwrap().is_some() {
                return Err(format!("{place}: `{line}` has ended"));
            }
            let id = child.id().to_string();
            assert!(Command::new("kill").args(["-TERM", &id]).status().unwrap().success());
        }
        while child.try_wait().unwrap().is_none() {
            if PATIENCE < begun.elapsed() {
                child.kill().unwrap();
                return Err(format!("{place}: `{line}` takes longer than {PATIENCE:?}"));
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        let output = child.wait_with_output().unwrap();
        let error = String::from_utf8_lossy(&output.stderr);
        if !output.status.success() {
            return Err(format!("{place}: `{line}`: {error}"));
        }
        println!("{place}: `{line}`: {:.1} s", begun.elapsed().as_secs_f64());
        for left in ["state", "fdiag-report", "gap-report"] {
            let _ = fs::remove_dir_all(self.path(left));
        }
        Ok(())
    }

    fn fdiag(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fdiag"));
        command.args(arguments).current_dir(self.folder.path()).stdin(Stdio::null());
        command
    }

    pub(crate) fn help(&self, path: &str) -> String {
        let words: Vec<&str> = path.split_whitespace().chain(["--help"]).collect();
        self.stdout(&words)
    }

    /// What a command that must succeed says.
    #[track_caller]
    pub(crate) fn stdout(&self, arguments: &[&str]) -> String {
        let output = self.fdiag(arguments).output().unwrap();
        assert!(output.status.success(), "{arguments:?}: {output:?}");
        String::from_utf8(output.stdout).unwrap()
    }

    /// The exit code and the complaint of a command that must end within so long.
    #[track_caller]
    pub(crate) fn fails(&self, arguments: &[&str], within: Duration) -> (Option<i32>, String) {
        let begun = Instant::now();
        let mut child =
            self.fdiag(arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        while child.try_wait().unwrap().is_none() {
            if within < begun.elapsed() {
                child.kill().unwrap();
                panic!("{arguments:?} takes longer than {within:?}");
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        let output = child.wait_with_output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    }
}

/// The rows of a log as samples of a unit.
fn samples(log: &str) -> String {
    let rows = log.lines().skip(2).map(|row| row.split(',').collect::<Vec<_>>());
    let line = |row: Vec<&str>| match row[..] {
        [time, fuel, speed, temperature] => format!(
            "{{\"rig\":\"p1\",\"time\":{time},\"wf\":{fuel},\"N\":{speed},\"T_7\":{temperature}}}\n"
        ),
        _ => panic!("a row of other columns: {row:?}"),
    };
    rows.map(line).collect()
}
