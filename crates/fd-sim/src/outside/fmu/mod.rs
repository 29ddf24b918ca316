//! An FMU for co-simulation, FMI 2.0 or 3.0 (Modelica Association, <https://fmi-standard.org>), as a simulator.
//!
//! Inputs, outputs, parameters, initial states and ports are variables of type `Real` (`Float64` in 3.0); ports are
//! inputs that the user names as such. The communication step is the sample time. An instance is reused for the next
//! run with `fmi2Reset` or `fmi3Reset`; parameters and initial states are set before it is initialised. Where a run
//! then begins otherwise than the same run in a fresh instance, the reset is not trusted, and each run has an instance
//! of its own. Of 3.0 there are no events, no intermediate updates, no clocks and no arrays.
//!
//! A crash of an FMU is a crash of the process that has loaded it, and what it prints is printed by that process.
//! Therefore a [`HostedFmu`] runs each instance in a process of its own, which [serves](serve_fmu) it by the
//! protocol of programs.
//!
//! *When not to use:* FMUs for model exchange, or of another version. Whether outputs with direct feedthrough reflect
//! the inputs of the same instant depends on the FMU; many return those of the step before.

mod api;
mod archive;
mod described;
mod description;
mod fault;
#[cfg(unix)]
mod hosted;
mod instance;
mod loaded;
#[cfg(unix)]
mod serve;

use std::{
    path::Path,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering::Relaxed},
    },
};

pub(super) use self::described::Described;
#[cfg(unix)]
pub(super) use self::hosted::{HostedFmu, host};
use self::{
    api::Api,
    description::{Description, Variable, Version},
    fault::fault,
    instance::FmuInstance,
    loaded::{LEAVES, Loaded},
};
#[cfg(unix)]
pub use self::{hosted::host_fmus, serve::serve_fmu};
use super::{
    contract::Contract,
    error::OutsideError,
    programs,
    source::{Instance, Source},
    stated::Stated,
};

/// An FMU, unpacked and loaded, with the meaning that its user gives to its variables.
#[derive(Clone, Debug)]
pub struct Fmu {
    loaded: Arc<Loaded>,
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
        programs::check(&path.display().to_string(), || "the library in it".to_owned())?;
        Self::of(Described::read(path, stated)?, false)
    }

    /// Loads the library of an FMU; into a process that is its own, or not.
    pub(super) fn of(described: Described, is_alone: bool) -> Result<Self, OutsideError> {
        let (version, file) = (described.description.version, &described.file);
        let api = Api::load(&described.library, version).map_err(|error| {
            fault(file, "its library", &format!("the functions of FMI {version}"), &error)
        })?;
        let loaded = Loaded {
            api,
            is_alone,
            visible: visible(&described.description),
            keeps_runs: AtomicBool::new(!described.contract.powers.resets),
            resources: resources(version, &described.root),
            described,
        };
        Ok(Self { loaded: Arc::new(loaded) })
    }

    /// What it is.
    #[must_use]
    pub fn contract(&self) -> &Contract {
        &self.loaded.described.contract
    }

    /// Whether this process may have one instance only.
    #[must_use]
    pub fn is_single(&self) -> bool {
        self.loaded.described.description.is_single
    }
}

impl Source for Fmu {
    fn open(&self) -> Result<Box<dyn Instance>, OutsideError> {
        Ok(Box::new(FmuInstance::open(&self.loaded)?))
    }

    fn note(&self) -> Option<String> {
        let keeps = self.loaded.keeps_runs.load(Relaxed) && self.contract().powers.resets;
        keeps.then(|| LEAVES.to_owned())
    }
}
