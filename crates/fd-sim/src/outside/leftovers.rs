//! What is left of simulators when a process ends at once: programs that run, folders of unpacked FMUs.

#[cfg(feature = "fmu")]
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use super::lock::open;

/// Groups of processes that were started.
static GROUPS: Mutex<Vec<u32>> = Mutex::new(Vec::new());
/// Folders that were made.
#[cfg(feature = "fmu")]
static FOLDERS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Ends all programs that simulators of this process are, with everything in their groups, and removes the folders that FMUs
/// were unpacked into: for a process that is about to end without taking its simulators apart.
///
/// ```
/// fd_sim::outside::end_programs();
/// ```
pub fn end_programs() {
    #[cfg(unix)]
    for group in open(&GROUPS).drain(..) {
        end(group);
    }
    #[cfg(feature = "fmu")]
    for folder in open(&FOLDERS).drain(..) {
        // Where it cannot be removed there is nobody left to tell.
        let _ = std::fs::remove_dir_all(folder);
    }
}

/// Ends a group of processes.
#[cfg(unix)]
pub(super) fn end(group: u32) {
    use rustix::process::{Pid, Signal, kill_process_group};
    if let Ok(id) = i32::try_from(group)
        && let Some(group) = Pid::from_raw(id)
    {
        // Also after its end: what it has started may still be there. There may be nobody left.
        let _ = kill_process_group(group, Signal::KILL);
    }
}

/// A program was started.
#[cfg(unix)]
pub(super) fn started(group: u32) {
    open(&GROUPS).push(group);
}

/// A program is no more.
#[cfg(unix)]
pub(super) fn ended(group: u32) {
    open(&GROUPS).retain(|known| *known != group);
}

/// A folder was made.
#[cfg(feature = "fmu")]
pub(super) fn made(folder: &Path) {
    open(&FOLDERS).push(folder.to_owned());
}

/// A folder is about to be removed.
#[cfg(feature = "fmu")]
pub(super) fn removed(folder: &Path) {
    open(&FOLDERS).retain(|known| known != folder);
}
