//! How much memory may be taken because a file says so.
//!
//! A file of two kilobytes can claim an array of gigabytes. What a file claims is therefore taken from a [`Budget`] first,
//! and asked of the system by [`reserve`], which can fail. What a program does with data that it has is not counted: the
//! default is a quarter of what there is, and reading, resampling and fitting a log take about as much again each.
//!
//! What there is: the least of the memory of the machine, the limit of its control group (containers), and the limit on
//! addresses of the process (`ulimit -v`). Elsewhere than on Linux none of them is known, and [`ELSEWHERE`] is assumed.
//! This is the one place of the libraries that looks at the machine.

use std::{
    collections::TryReserveError,
    fs,
    path::Path,
    sync::{
        OnceLock,
        atomic::{AtomicU64, Ordering::Relaxed},
    },
};

use thiserror::Error;

/// What is assumed to be there where the system does not say it: 8 GiB, so that files may claim 2 GiB.
pub const ELSEWHERE: u64 = 8 << 30;
/// Which part of what there is files may claim.
const SHARE: u64 = 4;
/// More than that needs to be asked for by [`set_budget`], however large the machine: 4 GiB.
pub const MOST: u64 = 4 << 30;

/// What was set; 0 where nothing was.
static SET: AtomicU64 = AtomicU64::new(0);

/// More memory is claimed than there may be.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum MemoryError {
    /// It is beyond the budget.
    #[error(
        "{what}: expected at most {most} bytes (what is left of the budget of memory), found {found}"
    )]
    Budget {
        /// What claims it.
        what: String,
        /// What is left, in bytes.
        most: u64,
        /// What is claimed, in bytes.
        found: u64,
    },
    /// The system does not give it.
    #[error("{what}: the system has no {bytes} bytes of memory")]
    Refused {
        /// What it was for.
        what: String,
        /// How much was asked for, in bytes.
        bytes: u64,
    },
    /// The budget was set before, to another value.
    #[error("the budget of memory is set once: expected {before} bytes again, found {found}")]
    SetTwice {
        /// The value that holds.
        before: u64,
        /// The other one.
        found: u64,
    },
}

/// The budget of this process, in bytes: what was set, else a quarter of what there is and at most [`MOST`].
#[must_use]
pub fn budget() -> u64 {
    static DEFAULT: OnceLock<u64> = OnceLock::new();
    match SET.load(Relaxed) {
        0 => *DEFAULT.get_or_init(|| (available().unwrap_or(ELSEWHERE) / SHARE).min(MOST)),
        set => set,
    }
}

/// Sets the budget, in bytes; 0 counts as 1. It holds for files that are opened from now on.
///
/// # Errors
///
/// Returns an error when another value was set before.
pub fn set_budget(bytes: u64) -> Result<(), MemoryError> {
    let found = bytes.max(1);
    match SET.compare_exchange(0, found, Relaxed, Relaxed) {
        Err(before) if before != found => Err(MemoryError::SetTwice { before, found }),
        _ => Ok(()),
    }
}

/// The budget that goes with a limit on the whole process, in bytes.
#[must_use]
pub fn share_of(limit: u64) -> u64 {
    limit / SHARE
}

/// What this process may have in all, in bytes; nothing where the system does not say it.
#[must_use]
pub fn available() -> Option<u64> {
    let [machine, limits] = ["/proc/meminfo", "/proc/self/limits"].map(fs::read_to_string);
    let machine = machine.ok().and_then(|text| of_machine(&text));
    let addresses = limits.ok().and_then(|text| of_addresses(&text));
    let groups = fs::read_to_string("/proc/self/cgroup").ok();
    let group = groups.and_then(|text| of_group(Path::new("/sys/fs/cgroup"), &text));
    [machine, addresses, group].into_iter().flatten().min()
}

/// `MemTotal:       24684152 kB`
fn of_machine(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

/// `Max address space         4096000000           unlimited            bytes`
fn of_addresses(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    line.split_whitespace().next()?.parse().ok()
}

/// The least limit of the group of this process and of those that it is in: `0::/user.slice` (version 2) or
/// `9:memory:/docker/…` (version 1). In a container, its own group may be the root that is seen.
fn of_group(root: &Path, groups: &str) -> Option<u64> {
    let mut least: Option<u64> = None;
    let mut look = |file: &Path| {
        let found = fs::read_to_string(file).ok().and_then(|text| text.trim().parse().ok());
        least = least.into_iter().chain(found).min();
    };
    for line in groups.lines() {
        let mut parts = line.splitn(3, ':');
        let (Some(_), Some(kind), Some(path)) = (parts.next(), parts.next(), parts.next()) else {
            continue;
        };
        let (base, name) = match kind {
            "" => (root.to_owned(), "memory.max"),
            kind if kind.split(',').any(|kind| kind == "memory") => {
                (root.join("memory"), "memory.limit_in_bytes")
            }
            _ => continue,
        };
        let own = Path::new(path.trim_start_matches('/'));
        for inside in own.ancestors() {
            look(&base.join(inside).join(name));
        }
    }
    least
}

/// What is left of a budget while a file is read.
///
/// ```
/// use fd_core::memory::Budget;
///
/// let mut left = Budget::of(1000);
/// left.take("the first array", 600)?;
/// let error = left.take("the second array", 600).map_err(|error| error.to_string());
/// let words = "the second array: expected at most 400 bytes (what is left of the budget of memory), found 600";
/// assert_eq!(error, Err(words.to_owned()));
/// # Ok::<(), fd_core::memory::MemoryError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Budget {
    left: u64,
}

impl Default for Budget {
    /// The whole budget of the process.
    fn default() -> Self {
        Self::of(budget())
    }
}

impl Budget {
    /// So many bytes.
    #[must_use]
    pub fn of(bytes: u64) -> Self {
        Self { left: bytes }
    }

    /// What is left, in bytes.
    #[must_use]
    pub fn left(&self) -> u64 {
        self.left
    }

    /// Takes bytes, before they are asked of the system.
    ///
    /// # Errors
    ///
    /// Returns an error when less is left; nothing is taken then.
    pub fn take(&mut self, what: &str, bytes: u64) -> Result<(), MemoryError> {
        self.left = self.left.checked_sub(bytes).ok_or_else(|| MemoryError::Budget {
            what: what.to_owned(),
            most: self.left,
            found: bytes,
        })?;
        Ok(())
    }
}

/// An empty list with room for so many entries, or the error that the system has none.
///
/// ```
/// let list = fd_core::memory::reserve::<f64>("a column", 8)?;
/// assert!(list.is_empty() && list.capacity() >= 8);
/// assert!(fd_core::memory::reserve::<f64>("a column", 1 << 60).is_err());
/// # Ok::<(), fd_core::memory::MemoryError>(())
/// ```
///
/// # Errors
///
/// Returns an error when the system does not give the memory.
pub fn reserve<T>(what: &str, entries: usize) -> Result<Vec<T>, MemoryError> {
    let mut list = Vec::new();
    list.try_reserve_exact(entries).map_err(|_: TryReserveError| MemoryError::Refused {
        what: what.to_owned(),
        bytes: (entries as u64).saturating_mul(size_of::<T>() as u64),
    })?;
    Ok(list)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_linux_says_is_understood() {
        assert_eq!(
            of_machine("MemTotal:       24684152 kB\nMemFree: 1 kB\n"),
            Some(24_684_152 * 1024)
        );
        assert_eq!(of_machine("rubbish"), None);
        let line = "Max address space         4096000000           unlimited            bytes";
        assert_eq!(of_addresses(line), Some(4_096_000_000));
        assert_eq!(of_addresses("Max address space         unlimited  unlimited  bytes"), None);
    }

    #[test]
    fn the_least_limit_of_all_groups_around_counts() {
        let root = std::env::temp_dir().join(format!("fd-core-memory-{}", std::process::id()));
        let write = |file: &str, text: &str| {
            let file = root.join(file);
            fs::create_dir_all(file.parent().unwrap()).unwrap();
            fs::write(file, text).unwrap();
        };
        write("memory.max", "max\n");
        write("a/memory.max", "3000\n");
        write("a/b/memory.max", "5000\n");
        write("memory/c/memory.limit_in_bytes", "2000\n");
        assert_eq!(of_group(&root, "0::/a/b\n"), Some(3000));
        assert_eq!(of_group(&root, "0::/\n"), None);
        assert_eq!(of_group(&root, "4:cpu,memory:/c\n0::/a\n"), Some(2000));
        assert_eq!(of_group(&root, "rubbish"), None);
        fs::remove_dir_all(root).unwrap();
    }

    #[test]
    fn the_default_is_a_quarter_and_a_value_is_set_once() {
        let there = available().unwrap_or(ELSEWHERE);
        assert_eq!(budget(), (there / 4).min(MOST));
        assert_eq!(set_budget(7), Ok(()));
        assert_eq!(set_budget(7), Ok(()));
        assert_eq!(set_budget(8), Err(MemoryError::SetTwice { before: 7, found: 8 }));
        assert_eq!((budget(), Budget::default().left()), (7, 7));
    }
}
