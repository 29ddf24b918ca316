//! An FMU that is loaded, and what is told of its resets.

use std::sync::{Arc, atomic::AtomicBool};

use super::{
    api::{Api, Component},
    described::Described,
    description::Description,
};

/// What is told of resets.
pub(super) const LEAVES: &str = "its reset says that it is done and leaves something of the run before: each run has a fresh \
                      instance, as with `[powers] resets = false`";
#[cfg(unix)]
pub(super) const ENDS: &str = "its process has ended when it was reset: each run has a fresh instance, as with `[powers] resets = \
                    false`";

/// What is on the disk, and in memory.
#[derive(Debug)]
pub(super) struct Loaded {
    /// Before the directory, so that the library is unloaded first.
    pub api: Arc<Api>,
    /// Variables that show where a run begins: outputs and locals.
    pub visible: Vec<u32>,
    /// Whether its reset is said, or was seen, to leave something of the run before: then each run has an instance of its
    /// own.
    pub keeps_runs: AtomicBool,
    /// Whether this process is its own: what is found out is told to who has started it.
    pub is_alone: bool,
    pub resources: String,
    pub described: Described,
}

impl Loaded {
    pub(super) fn component(&self) -> Result<Component, String> {
        let Description { name, token, .. } = &self.described.description;
        Component::new(&self.api, [name, token, &self.resources])
    }
}
