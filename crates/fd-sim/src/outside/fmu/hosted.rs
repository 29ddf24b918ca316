//! FMUs in processes of their own.

use std::{sync::OnceLock, time::Duration};

use super::{
    super::{
        contract::Contract,
        error::OutsideError,
        process::Process,
        source::{Instance, Source},
    },
    described::Described,
};

/// What serves an FMU.
static HOST: OnceLock<Vec<String>> = OnceLock::new();

/// From now on each instance of an FMU that a model file names has a process of its own, unless the file says
/// `in_process`. This command starts it, with the FMU as one more argument; it is to call [`serve_fmu`](super::serve_fmu), as
/// `fdiag simulator serve` does. The first command that is given stays.
///
/// ```
/// fd_sim::outside::host_fmus(["fdiag", "simulator", "serve"]);
/// ```
pub fn host_fmus<S: Into<String>>(command: impl IntoIterator<Item = S>) {
    HOST.get_or_init(|| command.into_iter().map(Into::into).collect());
}

/// What starts a process for an FMU, where that is known.
pub(in super::super) fn host() -> Option<&'static [String]> {
    HOST.get().map(Vec::as_slice).filter(|command| !command.is_empty())
}

/// An FMU whose instances have processes of their own.
#[derive(Debug)]
pub(in super::super) struct HostedFmu {
    process: Process,
    pub contract: Contract,
    /// What is unpacked is there as long as they run.
    _described: Described,
}

impl HostedFmu {
    /// An FMU that this command serves, and that may take so long for an answer.
    pub(in super::super) fn new(described: Described, host: &[String], timeout: Duration) -> Self {
        let root = described.root.display().to_string();
        let mut process = Process::new(host.iter().cloned().chain([root]));
        process.timeout = timeout;
        process.stated = described.stated.clone();
        process.title = Some(described.file.clone());
        let mut contract = described.contract.clone();
        // By as many steps on the other side.
        contract.powers.rollout = true;
        Self { process, contract, _described: described }
    }
}

impl Source for HostedFmu {
    fn open(&self) -> Result<Box<dyn Instance>, OutsideError> {
        if self.process.note().is_none() {
            return self.process.open();
        }
        // What one has told of its resets holds for the next.
        let mut process = self.process.clone();
        if let Some(powers) = &mut process.stated.powers {
            powers.resets = false;
        }
        process.open()
    }

    fn note(&self) -> Option<String> {
        self.process.note()
    }

    /// Fresh instances are made on the other side.
    fn renews(&self) -> bool {
        true
    }
}
