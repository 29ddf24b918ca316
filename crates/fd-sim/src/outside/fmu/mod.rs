//! An FMU for co-simulation, FMI 2.0 or 3.0 (Modelica Association, <https://fmi-standard.org>), as a simulator.
//!
//! Inputs, outputs, parameters, initial states and ports are variables of type `Real` (`Float64` in 3.0); ports are
//! inputs that the user names as such. The communication step is the sample time. An instance is reused for the next
//! run with `fmi2Reset` or `fmi3Reset`; parameters and initial states are set before it is initialised. Where a run
//! then begins otherwise than the same run in a fresh instance, the reset is not trusted, and each run has an instance
//! of its own. Of 3.0 there are no events, no intermediate updates, no clocks and no arrays.
//!
//! *When not to use:* FMUs for model exchange, or of another version; FMUs that crash, because this process
//! crashes with them: serve those from a separate process. Whether outputs with direct feedthrough reflect the
//! inputs of the same instant depends on the FMU; many return those of the step before.

mod api;
mod archive;
mod description;
mod instance;

use std::{
    fs,
    path::{Path, PathBuf},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering::Relaxed},
    },
};

use fd_model::nearest;
use tempfile::TempDir;

use self::{
    api::{Api, Component},
    description::{Description, Variable, Version},
    instance::{FmuInstance, References},
};
use super::{
    contract::{Contract, Entry, Stated},
    error::OutsideError,
    leftovers,
    powers::Powers,
    programs,
    source::{Instance, Source},
};

/// An FMU, unpacked and loaded, with the meaning that its user gives to its variables.
#[derive(Clone, Debug)]
pub struct Fmu {
    file: String,
    contract: Contract,
    references: Arc<References>,
    unpacked: Arc<Unpacked>,
}

/// What is on the disk, and in memory.
#[derive(Debug)]
struct Unpacked {
    /// Before the directory, so that the library is unloaded first.
    api: Arc<Api>,
    description: Description,
    /// Variables that show where a run begins: outputs and locals.
    visible: Vec<u32>,
    /// Whether its reset was seen to leave something of the run before: then each run has an instance of its own.
    keeps_runs: AtomicBool,
    resources: String,
    directory: Option<TempDir>,
}

impl Drop for Unpacked {
    fn drop(&mut self) {
        if let Some(directory) = &self.directory {
            leftovers::removed(directory.path());
        }
    }
}

impl Unpacked {
    fn component(&self) -> Result<Component, String> {
        let Description { name, token, .. } = &self.description;
        Component::new(&self.api, [name, token, &self.resources])
    }
}

/// Where FMUs of a version keep the library for this machine.
fn platform(version: Version) -> Result<&'static str, &'static str> {
    use Version::{Three, Two};
    Ok(match (version, std::env::consts::OS, std::env::consts::ARCH) {
        (Two, "linux", "x86_64") => "linux64",
        (Two, "linux", "x86") => "linux32",
        (Two, "macos", _) => "darwin64",
        (Two, "windows", "x86_64") => "win64",
        (Two, "windows", "x86") => "win32",
        (Three, "linux", "x86_64") => "x86_64-linux",
        (Three, "linux", "x86") => "x86-linux",
        (Three, "macos", "x86_64") => "x86_64-darwin",
        (Three, "macos", "aarch64") => "aarch64-darwin",
        (Three, "windows", "x86_64") => "x86_64-windows",
        (Three, "windows", "x86") => "x86-windows",
        (_, "linux", "aarch64") => "aarch64-linux",
        _ => return Err("a platform that FMUs have a name for"),
    })
}

/// References of what a run shows, each once.
fn visible(description: &Description) -> Vec<u32> {
    let is_seen = |v: &&Variable| matches!(v.causality.as_str(), "output" | "local");
    let mut seen: Vec<u32> =
        description.variables.iter().filter(is_seen).map(|v| v.reference).collect();
    seen.sort_unstable();
    seen.dedup();
    seen
}

/// The library in a folder, if there is one only.
fn only_library(folder: &Path) -> Option<PathBuf> {
    let ending = std::env::consts::DLL_EXTENSION;
    let files = fs::read_dir(folder).ok()?.flatten().map(|entry| entry.path());
    let mut libraries = files.filter(|file| file.extension().is_some_and(|e| e == ending));
    let first = libraries.next()?;
    libraries.next().is_none().then_some(first)
}

/// How an FMU of a version is told where its resources are: by a URI, in 3.0 by a path that ends with a separator.
fn resources(version: Version, root: &Path) -> String {
    let resources = root.join("resources");
    match version {
        Version::Two => format!("file://{}", resources.display()),
        Version::Three => format!("{}{}", resources.display(), std::path::MAIN_SEPARATOR),
    }
}

impl Fmu {
    /// Loads an FMU, or the directory of an unpacked one. `stated` is what the user says: a sample time; which
    /// variables are inputs and outputs (all of them if none is said), parameters, states and ports, each by its name
    /// or as the `variable` of an entry. Units and values that are not said are those of the FMU.
    ///
    /// ```
    /// use std::path::Path;
    /// use fd_sim::outside::{Fmu, Stated};
    ///
    /// let error = Fmu::load(Path::new("no-such.fmu"), &Stated::default()).unwrap_err();
    /// assert!(error.to_string().starts_with("no-such.fmu: the file: expected"));
    /// ```
    ///
    /// # Errors
    ///
    /// Returns what is wrong with the FMU, or with what is said of it.
    pub fn load(path: &Path, stated: &Stated) -> Result<Self, OutsideError> {
        let file = path.display().to_string();
        programs::check(&file, || "the library in it".to_owned())?;
        let wrong =
            |what: &str, expected: &str, found: String| fault(&file, what, expected, &found);
        let unreadable =
            |error: std::io::Error| wrong("the file", "to be readable", error.to_string());
        let (root, directory): (PathBuf, Option<TempDir>) = if path.is_dir() {
            (path.to_owned(), None)
        } else {
            let archive = fs::read(path).map_err(unreadable)?;
            let directory = tempfile::tempdir().map_err(unreadable)?;
            leftovers::made(directory.path());
            archive::unpack(&archive, directory.path())
                .map_err(|(what, expected, found)| wrong(&what, expected, found))?;
            (directory.path().to_owned(), Some(directory))
        };
        let root = std::path::absolute(root).map_err(unreadable)?;
        let text = fs::read_to_string(root.join("modelDescription.xml"))
            .map_err(|error| wrong("modelDescription.xml", "to be there", error.to_string()))?;
        let description = Description::read(&text)
            .map_err(|(what, expected, found)| wrong(&what, &expected, found))?;
        let version = description.version;
        let platform =
            platform(version).map_err(|e| wrong("this machine", e, "another".to_owned()))?;
        let binaries = root.join("binaries");
        let name = format!("{}{}", description.identifier, std::env::consts::DLL_SUFFIX);
        let mut library = binaries.join(platform).join(&name);
        if !library.exists()
            && let Some(only) = only_library(&binaries.join(platform))
        {
            // Some exporters rename the library and not what the description says of it.
            library = only;
        }
        if !library.exists() {
            let names = fs::read_dir(&binaries).into_iter().flatten().flatten();
            let mut names: Vec<_> =
                names.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
            names.sort_unstable();
            let expected = format!("{platform}/{name}");
            return Err(wrong("binaries", &expected, format!("`{}`", names.join("`, `"))));
        }
        let api = Api::load(&library, version).map_err(|error| {
            wrong("its library", &format!("the functions of FMI {version}"), error)
        })?;
        let (contract, references) = meaning(&file, &description, stated)?;
        let resources = resources(version, &root);
        Ok(Self {
            contract,
            references: Arc::new(references),
            unpacked: Arc::new(Unpacked {
                visible: visible(&description),
                keeps_runs: AtomicBool::new(false),
                api,
                description,
                resources,
                directory,
            }),
            file,
        })
    }

    /// What it is.
    #[must_use]
    pub fn contract(&self) -> &Contract {
        &self.contract
    }

    /// Whether this process may have one instance only.
    #[must_use]
    pub fn is_single(&self) -> bool {
        self.unpacked.description.is_single
    }

    fn wrong(&self, what: &str, expected: &str, found: &str) -> OutsideError {
        fault(&self.file, what, expected, found)
    }
}

impl Source for Fmu {
    fn open(&self) -> Result<Box<dyn Instance>, OutsideError> {
        Ok(Box::new(FmuInstance::open(self)?))
    }

    fn note(&self) -> Option<String> {
        let keeps = self.unpacked.keeps_runs.load(Relaxed);
        keeps.then(|| {
            "its reset says that it is done and leaves something of the run before: each run has a fresh instance, as \
             with `[powers] resets = false`"
                .to_owned()
        })
    }
}

fn fault(file: &str, what: &str, expected: &str, found: &str) -> OutsideError {
    OutsideError::Fmu {
        file: file.to_owned(),
        what: what.to_owned(),
        expected: expected.to_owned(),
        found: found.to_owned(),
    }
}

/// The contract that a user's words and the description make, and the references of its variables.
fn meaning(
    file: &str,
    description: &Description,
    stated: &Stated,
) -> Result<(Contract, References), OutsideError> {
    let mut stated = stated.clone();
    let name = |entry: &Entry| entry.variable.clone().unwrap_or_else(|| entry.name.clone());
    let ports: Vec<String> = stated.ports.iter().map(name).collect();
    let all = |causality: &str| -> Vec<Entry> {
        let is_it = |v: &&Variable| v.causality == causality && !ports.contains(&v.name);
        let entry = |v: &Variable| Entry { name: v.name.clone(), ..Entry::default() };
        description.variables.iter().filter(is_it).map(entry).collect()
    };
    if stated.inputs.is_empty() {
        stated.inputs = all("input");
    }
    if stated.outputs.is_empty() {
        stated.outputs = all("output");
    }
    let known = |room: &str, entry: &mut Entry, causes: &[&str]| -> Result<u32, OutsideError> {
        let wanted = name(entry);
        let fits = |v: &&Variable| causes.is_empty() || causes.contains(&v.causality.as_str());
        let names = description.variables.iter().filter(fits).map(|v| v.name.as_str());
        let found = description.variables.iter().find(|v| v.name == wanted);
        let Some(variable) = found.filter(fits) else {
            let what = format!("{room}.{}", entry.name);
            let kinds = causes.join(" or ");
            let expected = format!(
                "the name of a real variable{}{kinds}",
                if kinds.is_empty() { "" } else { " of causality " }
            );
            let near = nearest(&wanted, names);
            let hint = near.first().map_or(String::new(), |n| format!("; did you mean `{n}`?"));
            let is = found.map_or("", |v| v.causality.as_str());
            let is = if is.is_empty() { String::new() } else { format!(" ({is})") };
            return Err(fault(file, &what, &expected, &format!("`{wanted}`{is}{hint}")));
        };
        let unit = || variable.unit.clone().unwrap_or_else(|| "1".to_owned());
        entry.unit = entry.unit.take().or_else(|| Some(unit()));
        match room {
            "parameters" | "native_effects" => entry.value = entry.value.or(variable.start),
            "states" => entry.initial = entry.initial.or(variable.start),
            _ => {}
        }
        Ok(variable.reference)
    };
    let mut each = |room: &str, causes: &[&str]| -> Result<Vec<u32>, OutsideError> {
        let entries = match room {
            "inputs" => &mut stated.inputs,
            "ports" => &mut stated.ports,
            "outputs" => &mut stated.outputs,
            "parameters" => &mut stated.parameters,
            "native_effects" => &mut stated.native_effects,
            _ => &mut stated.states,
        };
        entries.iter_mut().map(|entry| known(room, entry, causes)).collect()
    };
    let mut inputs = each("inputs", &["input"])?;
    inputs.extend(each("ports", &["input"])?);
    let mut parameters = each("parameters", &["parameter"])?;
    parameters.extend(each("native_effects", &["parameter"])?);
    let references = References {
        inputs,
        outputs: each("outputs", &["output", "local"])?,
        parameters,
        states: each("states", &[])?,
    };
    let shows = !stated.states.is_empty();
    stated.name = stated.name.or_else(|| Some(description.name.clone()));
    let measures = Powers { measure: true, states: shows, ..Powers::default() };
    stated.powers = Some(stated.powers.unwrap_or(measures));
    if let Some(powers) = &mut stated.powers {
        // Whatever is said: that is how it is asked.
        (powers.step, powers.rollout, powers.measure, powers.states) = (true, false, true, shows);
    }
    Ok((stated.settle(file)?, references))
}
