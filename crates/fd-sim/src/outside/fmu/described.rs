//! What an FMU says of itself, together with what its user says: all that can be known without its library.

use std::{
    fs,
    path::{Path, PathBuf},
};

use fd_model::nearest;
use tempfile::TempDir;

use super::{
    super::{
        contract::Contract,
        error::OutsideError,
        leftovers,
        powers::Powers,
        stated::{Entry, Stated},
    },
    archive,
    description::{Description, Variable, Version},
    fault::fault,
};

/// References of the variables of a contract, in its order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct References {
    /// Inputs, then ports.
    pub inputs: Vec<u32>,
    pub outputs: Vec<u32>,
    pub parameters: Vec<u32>,
    pub states: Vec<u32>,
}

/// An FMU on the disk, with the meaning that its user gives to its variables.
#[derive(Debug)]
pub(in super::super) struct Described {
    /// The FMU, for messages.
    pub(super) file: String,
    pub(super) description: Description,
    /// What is said of it, complete.
    pub(super) stated: Stated,
    pub(super) contract: Contract,
    pub(super) references: References,
    /// Where it is unpacked.
    pub(super) root: PathBuf,
    /// Its library for this machine.
    pub(super) library: PathBuf,
    /// What is to be removed in the end.
    directory: Option<TempDir>,
}

impl Drop for Described {
    fn drop(&mut self) {
        if let Some(directory) = &self.directory {
            leftovers::removed(directory.path());
        }
    }
}

impl Described {
    /// Reads an FMU, or the directory of an unpacked one.
    pub(in super::super) fn read(path: &Path, stated: &Stated) -> Result<Self, OutsideError> {
        let file = path.display().to_string();
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
        let library = library(&file, &root, &description)?;
        let (stated, references) = meaning(&file, &description, stated)?;
        let contract = stated.clone().settle(&file)?;
        Ok(Self { file, description, stated, contract, references, root, library, directory })
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

/// The library for this machine.
fn library(file: &str, root: &Path, description: &Description) -> Result<PathBuf, OutsideError> {
    let version = description.version;
    let platform = platform(version).map_err(|e| fault(file, "this machine", e, "another"))?;
    let binaries = root.join("binaries");
    let name = format!("{}{}", description.identifier, std::env::consts::DLL_SUFFIX);
    let library = binaries.join(platform).join(&name);
    if library.exists() {
        return Ok(library);
    }
    // Some exporters rename the library and not what the description says of it.
    only_library(&binaries.join(platform)).ok_or_else(|| {
        let names = fs::read_dir(&binaries).into_iter().flatten().flatten();
        let mut names: Vec<_> =
            names.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        names.sort_unstable();
        let found = format!("`{}`", names.join("`, `"));
        fault(file, "binaries", &format!("{platform}/{name}"), &found)
    })
}

/// The library in a folder, if there is one only.
fn only_library(folder: &Path) -> Option<PathBuf> {
    let ending = std::env::consts::DLL_EXTENSION;
    let files = fs::read_dir(folder).ok()?.flatten().map(|entry| entry.path());
    let mut libraries = files.filter(|file| file.extension().is_some_and(|e| e == ending));
    let first = libraries.next()?;
    libraries.next().is_none().then_some(first)
}

/// What a user's words and the description say together, and the references of its variables.
fn meaning(
    file: &str,
    description: &Description,
    stated: &Stated,
) -> Result<(Stated, References), OutsideError> {
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
    Ok((stated, references))
}
