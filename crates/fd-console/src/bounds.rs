//! `--time-limit` and `--memory-limit`: how long a command may take, and how much memory.
//!
//! A thread of its own looks at both. When one is reached, programs that were started are ended, directories that were made
//! for results are removed again, and the process ends with exit code 6. Results that are being written are written: each
//! file is whole, and nothing is left of a command that was cut off before its first result.

use std::{
    path::{Path, PathBuf},
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, Ordering::Relaxed},
    },
    time::{Duration, Instant},
};

use clap::Args;
use fdiag::{core::memory, model::duration, sim::outside};

use crate::{failure::Failure, patience::time, say::complain};

/// How often it is looked.
const LOOK: Duration = Duration::from_millis(10);
/// How long a file that is being written is waited for.
const WRITING_TAKES: Duration = Duration::from_secs(10);

/// What a command may take.
#[derive(Clone, Copy, Debug, Default, Args)]
pub struct BoundsArgs {
    /// End after this long (`90s`, `10min`, `2h`); `gap` and `watch` end in order, with what there is by then
    #[arg(long, value_name = "TIME", global = true, value_parser = time)]
    pub time_limit: Option<Duration>,
    /// End when the process takes more memory than this (`500MB`, `2GB`); files may claim a quarter of it
    #[arg(long, value_name = "SIZE", global = true, value_parser = size)]
    pub memory_limit: Option<u64>,
}

/// What happens when the time is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// The process ends.
    AtOnce,
    /// The command ends by itself, with what there is by then; the process ends where that takes as long again.
    InOrder,
}

/// A command that is looked at for as long as this lives.
#[derive(Debug)]
#[must_use = "nobody looks any more when this is dropped"]
pub struct Watched(Arc<AtomicBool>);

impl Drop for Watched {
    fn drop(&mut self) {
        self.0.store(true, Relaxed);
        // What was ended from below, a program whose reader is this command, is no result: the code is that of the limit.
        drop(open(&ENDING));
    }
}

/// Held for good once the process is being ended.
static ENDING: Mutex<()> = Mutex::new(());
/// Directories that were made for results, and whether results are being written.
static MADE: Mutex<(Vec<PathBuf>, bool)> = Mutex::new((Vec::new(), false));
/// Held while a file is written.
static WRITING: Mutex<()> = Mutex::new(());
/// Told that the time is over, instead of the process being ended.
static INSTEAD: Mutex<Option<Arc<AtomicBool>>> = Mutex::new(None);
/// Whether the time was over.
static IS_OVER: AtomicBool = AtomicBool::new(false);

fn open<T>(lock: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    lock.lock().unwrap_or_else(PoisonError::into_inner)
}

impl BoundsArgs {
    /// Begins to look at what the command takes.
    ///
    /// # Errors
    ///
    /// A limit on memory where the system does not say how much is taken, or a second one in the same process.
    pub fn begin(&self, ending: Ending) -> Result<Watched, Failure> {
        let watched = Watched(Arc::default());
        IS_OVER.store(false, Relaxed);
        if let Some(limit) = self.memory_limit {
            if resident().is_none() {
                let reason = "--memory-limit: this system does not say how much memory is taken";
                return Err(Failure::analysis(reason));
            }
            memory::set_budget(memory::share_of(limit)).map_err(Failure::analysis)?;
        }
        if self.time_limit.is_some() || self.memory_limit.is_some() {
            let (bounds, begun, is_done) = (*self, Instant::now(), Arc::clone(&watched.0));
            std::thread::spawn(move || bounds.watch(begun, ending, &is_done));
        }
        Ok(watched)
    }

    fn watch(self, begun: Instant, ending: Ending, is_done: &AtomicBool) {
        let Self { time_limit, memory_limit } = self;
        while !is_done.load(Relaxed) {
            if let Some(limit) = memory_limit
                && let Some(taken) = resident().filter(|taken| limit < *taken)
            {
                let [taken, limit] = [taken, limit].map(shown);
                end(&format!("it takes {taken} of memory, more than --memory-limit {limit}"));
            }
            if let Some(limit) = time_limit.filter(|limit| *limit <= begun.elapsed()) {
                let words =
                    format!("the time is over: --time-limit {}", duration(limit.as_secs_f64()));
                if let Some(flag) = open(&INSTEAD).take() {
                    complain(&format!("fdiag: {words}"));
                    IS_OVER.store(true, Relaxed);
                    flag.store(true, Relaxed);
                }
                let has_begun = open(&MADE).1;
                if ending == Ending::AtOnce && !has_begun
                    || 2 * limit + WRITING_TAKES < begun.elapsed()
                {
                    end(&words);
                }
            }
            std::thread::sleep(LOOK);
        }
    }
}

/// Ends the process with nothing left behind.
fn end(words: &str) -> ! {
    std::mem::forget(open(&ENDING));
    let begun = Instant::now();
    // A file that is being written is nearly done; where it is not, the disk is stuck.
    while begun.elapsed() < WRITING_TAKES {
        if let Ok(lock) = WRITING.try_lock() {
            std::mem::forget(lock);
            break;
        }
        std::thread::sleep(LOOK);
    }
    outside::end_programs();
    let made = open(&MADE);
    for directory in &made.0 {
        // Fails, as it should, when there is something in it.
        let _ = std::fs::remove_dir(directory);
    }
    // None is made any more.
    std::mem::forget(made);
    let failure = Failure::Limit(words.to_owned());
    complain(&format!("fdiag: {failure}"));
    std::process::exit(i32::from(failure.code().0))
}

/// Lets a command end in order when the time is over: the flag is set then.
pub fn told(flag: Arc<AtomicBool>) {
    *open(&INSTEAD) = Some(flag);
}

/// Whether the time was over, and a command that was [`told`] has ended for it.
#[must_use]
pub fn is_over() -> bool {
    IS_OVER.load(Relaxed)
}

/// Makes directories for results, innermost first: as a whole, or not at all where the process ends.
pub(crate) fn making<T>(directories: &[&Path], make: impl FnOnce() -> T) -> T {
    let mut made = open(&MADE);
    *made = (directories.iter().map(|path| (*path).to_owned()).collect(), false);
    make()
}

/// Does not end the process while a file is written; what has begun to be written is written to its end.
pub(crate) fn writing<T>(write: impl FnOnce() -> T) -> T {
    let _lock = open(&WRITING);
    open(&MADE).1 = true;
    write()
}

/// Resident bytes of this process; nothing where the system does not say it.
fn resident() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

/// A size in words.
fn shown(bytes: u64) -> String {
    match bytes as f64 {
        bytes if bytes < 1e9 => format!("{:.0} MB", bytes / 1e6),
        bytes => format!("{:.1} GB", bytes / 1e9),
    }
}

/// A size with its unit, at least a megabyte.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "was compared")]
fn size(text: &str) -> Result<u64, String> {
    const UNITS: [(&str, f64); 6] = [
        ("MiB", 1_048_576.0),
        ("GiB", 1_073_741_824.0),
        ("TiB", 1_099_511_627_776.0),
        ("MB", 1e6),
        ("GB", 1e9),
        ("TB", 1e12),
    ];
    let bytes = UNITS.iter().find_map(|(unit, bytes)| {
        let number = text.trim().strip_suffix(unit)?.trim().parse::<f64>().ok()?;
        Some(number * bytes)
    });
    match bytes {
        Some(bytes) if (1e6..1e18).contains(&bytes) => Ok(bytes as u64),
        _ => {
            Err("expected a size of at least 1MB with its unit, such as `500MB` or `2GB`"
                .to_owned())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_a_unit() {
        assert_eq!(size("2GB"), Ok(2_000_000_000));
        assert_eq!(size("1.5 GiB"), Ok(1_610_612_736));
        for wrong in ["", "2", "2kB", "0GB", "-1GB", "NaNGB", "1e30GB", "2 gb"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
        assert_eq!((shown(2_500_000_000), shown(64_000_000)), ("2.5 GB".into(), "64 MB".into()));
    }
}
