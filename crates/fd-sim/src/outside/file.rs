//! The model file of an outside simulator: `kind = "process"` or `kind = "fmu"`.

use std::{
    ops::Range,
    path::{Path, PathBuf},
    time::Duration,
};

use serde::Deserialize;
use toml::Spanned;

use super::{
    error::OutsideError,
    powers::Powers,
    programs,
    simulator::OutsideSimulator,
    stated::{Entry, Stated},
};
use crate::{
    model::{Draft, Model, Ordered},
    simulate::{Nominal, Shell, SimulateError, Simulator},
};

/// Format version that this program reads.
const VERSION: u32 = 1;
/// Kinds of such files.
pub const OUTSIDE_KINDS: &[&str] = &["process", "fmu"];

/// A model file of a simulator outside of this program.
///
/// ```
/// use std::path::Path;
/// use fd_sim::outside::OutsideFile;
///
/// let text = r#"
/// version = 1
/// kind = "process"
/// command = ["python3", "cart.py"]
/// workers = 2
/// timeout = 10
/// parameters = { mass = { tolerance = 0.01 } }
/// "#;
/// let file = OutsideFile::parse(Path::new("cart.toml"), text)?;
/// assert_eq!(file.workers, 2);
/// # Ok::<(), fd_sim::outside::OutsideError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct OutsideFile {
    /// The file, for messages.
    file: String,
    /// Its text, which is kept when effects are written into it.
    text: String,
    /// Where the entries for `directory` and `equations` are in it.
    replaced: Vec<Range<usize>>,
    /// Where relative paths begin.
    directory: PathBuf,
    command: Vec<String>,
    timeout: Duration,
    /// Whether an FMU is loaded into this process.
    in_process: bool,
    /// The FMU that it is, if it is one.
    fmu: Option<PathBuf>,
    /// Most simulators at once.
    pub workers: usize,
    /// What is said of it.
    stated: Stated,
    /// Equations around it, as a diagnosis writes them.
    equations: Option<String>,
}

/// The file as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    version: u32,
    kind: String,
    name: Option<String>,
    #[serde(rename = "description")]
    _description: Option<String>,
    #[serde(default)]
    command: Vec<String>,
    fmu: Option<PathBuf>,
    directory: Option<Spanned<PathBuf>>,
    #[serde(default = "one")]
    workers: usize,
    timeout: Option<f64>,
    in_process: Option<bool>,
    sample_time: Option<f64>,
    powers: Option<Powers>,
    #[serde(default)]
    parameters: Ordered<Entry>,
    #[serde(default)]
    inputs: Ordered<Entry>,
    #[serde(default)]
    states: Ordered<Entry>,
    #[serde(default)]
    outputs: Ordered<Entry>,
    #[serde(default)]
    ports: Ordered<Entry>,
    #[serde(default)]
    native_effects: Ordered<Entry>,
    equations: Option<Spanned<String>>,
}

fn one() -> usize {
    1
}

/// Longest time for an answer, in seconds, where the file says none: of a program, and of an FMU, whose steps are not
/// counted against it one by one.
const TIMEOUTS: [f64; 2] = [30.0, 600.0];

fn named(entries: Ordered<Entry>) -> Vec<Entry> {
    let each = entries.0.into_iter();
    each.map(|(name, entry)| Entry { name: name.into_inner(), ..entry }).collect()
}

/// The lines of an entry with this value.
fn lines(text: &str, value: Range<usize>) -> Range<usize> {
    let start = text[..value.start].rfind('\n').map_or(0, |newline| newline + 1);
    let end = text[value.end..].find('\n').map_or(text.len(), |n| value.end + n + 1);
    start..end
}

impl OutsideFile {
    /// Reads the text of a file. Relative paths in it begin where the file is.
    ///
    /// # Errors
    ///
    /// Returns the first entry that is wrong.
    pub fn parse(path: &Path, text: &str) -> Result<Self, OutsideError> {
        let file = path.display().to_string();
        let read: Written = toml::from_str(text).map_err(|error| OutsideError::Syntax {
            file: file.clone(),
            message: error.to_string(),
        })?;
        let timeout = read.timeout.unwrap_or(TIMEOUTS[usize::from(read.kind == "fmu")]);
        let checks = [
            (read.version == VERSION, "version", "1", read.version.to_string()),
            (
                OUTSIDE_KINDS.contains(&read.kind.as_str()),
                "kind",
                "`process` or `fmu`",
                format!("`{}`", read.kind),
            ),
            (
                (read.kind == "process") != read.command.is_empty(),
                "command",
                if read.kind == "process" { "a program" } else { "none, for an FMU" },
                if read.command.is_empty() { "none" } else { "one" }.to_owned(),
            ),
            (
                (read.kind == "fmu") == read.fmu.is_some(),
                "fmu",
                if read.kind == "fmu" { "the path of an FMU" } else { "none, for a process" },
                if read.fmu.is_none() { "none" } else { "one" }.to_owned(),
            ),
            (0 < read.workers, "workers", "at least 1", read.workers.to_string()),
            (
                0.0 < timeout && timeout.is_finite(),
                "timeout",
                "seconds above 0",
                timeout.to_string(),
            ),
            (
                read.kind == "fmu" || read.in_process.is_none(),
                "in_process",
                "none, for a process",
                "one".to_owned(),
            ),
            (
                read.sample_time.is_none_or(|ts| 0.0 < ts && ts.is_finite()),
                "sample_time",
                "seconds above 0",
                read.sample_time.unwrap_or_default().to_string(),
            ),
        ];
        if let Some((_, key, expected, found)) = checks.into_iter().find(|(is_fine, ..)| !is_fine) {
            let (key, expected) = (key.to_owned(), expected.to_owned());
            return Err(OutsideError::Value { place: file, key, expected, found });
        }
        // A file that is named without a folder is in this one.
        let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
        let here = parent.unwrap_or_else(|| Path::new("."));
        let spans = [
            read.directory.as_ref().map(Spanned::span),
            read.equations.as_ref().map(Spanned::span),
        ];
        let stated = Stated {
            name: read.name,
            sample_time: read.sample_time,
            inputs: named(read.inputs),
            outputs: named(read.outputs),
            parameters: named(read.parameters),
            states: named(read.states),
            ports: named(read.ports),
            native_effects: named(read.native_effects),
            powers: read.powers,
        };
        stated.check(&file)?;
        Ok(Self {
            file,
            text: text.to_owned(),
            replaced: spans.into_iter().flatten().map(|span| lines(text, span)).collect(),
            directory: read
                .directory
                .map_or_else(|| here.to_owned(), |d| here.join(d.into_inner())),
            command: read.command,
            in_process: read.in_process.unwrap_or(false),
            fmu: read.fmu,
            timeout: Duration::try_from_secs_f64(timeout).unwrap_or(Duration::MAX),
            workers: read.workers,
            stated,
            equations: read.equations.map(Spanned::into_inner),
        })
    }

    /// The FMU that it is of, if it is of one, and what it says of it.
    #[must_use]
    pub fn fmu(&self) -> Option<(PathBuf, &Stated)> {
        let path = self.fmu.as_ref()?;
        Some((self.directory.join(path), &self.stated))
    }

    /// Starts the simulator, at least once, and asks what it is.
    ///
    /// # Errors
    ///
    /// Returns why it cannot be started, or what is wrong with what it says; and an error where programs are forbidden
    /// ([`forbid_programs`](super::forbid_programs)).
    pub fn open(&self) -> Result<OutsideSimulator, OutsideError> {
        // Again where it is started: this one knows the file.
        programs::check(&self.file, || match &self.fmu {
            Some(fmu) => format!("the library in `{}`", fmu.display()),
            None => format!("`{}`", self.command.join(" ")),
        })?;
        match &self.fmu {
            Some(path) => self.open_fmu(&self.directory.join(path)),
            None => self.open_process(),
        }
    }

    #[cfg(feature = "fmu")]
    fn open_fmu(&self, path: &Path) -> Result<OutsideSimulator, OutsideError> {
        let described = super::fmu::Described::read(path, &self.stated)?;
        #[cfg(unix)]
        if let Some(host) = super::fmu::host().filter(|_| !self.in_process) {
            let fmu = super::fmu::HostedFmu::new(described, host, self.timeout);
            return OutsideSimulator::new(fmu.contract.clone(), fmu, self.workers);
        }
        let fmu = super::Fmu::of(described, false)?;
        let workers = if fmu.is_single() { 1 } else { self.workers };
        OutsideSimulator::new(fmu.contract().clone(), fmu, workers)
    }

    #[cfg(not(feature = "fmu"))]
    #[expect(clippy::unused_self, reason = "the same call as with the feature")]
    fn open_fmu(&self, path: &Path) -> Result<OutsideSimulator, OutsideError> {
        Err(OutsideError::Fmu {
            file: path.display().to_string(),
            what: "this program".to_owned(),
            expected: "the feature `fmu`".to_owned(),
            found: "one that was built without it".to_owned(),
        })
    }

    #[cfg(unix)]
    fn open_process(&self) -> Result<OutsideSimulator, OutsideError> {
        let mut process = super::Process::new(self.command.iter().cloned());
        process.directory.clone_from(&self.directory);
        process.timeout = self.timeout;
        process.stated = self.stated.clone();
        OutsideSimulator::new(process.contract()?, process, self.workers)
    }

    /// Processes need other means here.
    #[cfg(not(unix))]
    fn open_process(&self) -> Result<OutsideSimulator, OutsideError> {
        let message = "processes are simulators on Unix only, so far".to_owned();
        Err(OutsideError::Start { command: self.command.join(" "), message })
    }

    /// A shell around the simulator, with the noise of its outputs and what its ports move; or the equations that
    /// a diagnosis has written.
    ///
    /// # Errors
    ///
    /// Returns an error when the file's sample time is no multiple of the simulator's, or its equations are not
    /// those of this shell.
    pub fn shell(&self, simulator: &OutsideSimulator) -> Result<Shell, SimulateError> {
        let shell = simulator.shell()?;
        if let Some(text) = &self.equations {
            return shell.with_model(text.parse::<Model>()?);
        }
        let (own, ts) = (simulator.ts().seconds(), self.stated.sample_time);
        let ts = ts.unwrap_or(own);
        let ratio = ts / own;
        if ratio.round() < 1.0 || 1e-9 * ratio < (ratio - ratio.round()).abs() {
            return Err(SimulateError::Rate { own, ts });
        }
        let draft = Draft { sample_time: ts, ..shell.model().clone().into_draft() };
        shell.with_model(Model::try_from(draft)?)
    }

    /// The text of the file with other equations around the simulator.
    #[must_use]
    pub fn text(&self, model: &Model) -> String {
        let directory = std::path::absolute(&self.directory);
        let directory = directory.unwrap_or_else(|_| self.directory.clone());
        let quoted = |text: String| toml::Value::String(text).to_string();
        let mut rest = self.text.clone();
        let mut replaced = self.replaced.clone();
        replaced.sort_by_key(|range| std::cmp::Reverse(range.start));
        for range in replaced {
            rest.replace_range(range, "");
        }
        format!(
            "directory = {}\nequations = {}\n{rest}",
            quoted(directory.display().to_string()),
            quoted(format!("\n{model}"))
        )
    }
}
