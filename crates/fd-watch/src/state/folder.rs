//! The folder as a whole.

use std::{
    collections::HashMap,
    fmt::Write as _,
    fs::{self, File, TryLockError},
    io,
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{
    Identity,
    journal::{Found, Journal, JournalError},
    sealed,
};
use crate::{
    memory::{LearnedRows, MemoryError, UnitMemory},
    message::Message,
    monitor::Monitor,
};

/// Version of the way in which states are kept.
const FORMAT: u32 = 1;
/// Longest name of a file that is made of the name of a unit.
const LONGEST_NAME: usize = 120;

/// The state of a monitor on disk.
///
/// Order is everything here: an alarm is in the journal before it is published ([`StateFolder::promise`]), it is
/// published before its unit is saved, and a unit is saved as a whole or not at all ([`StateFolder::save`]). So
/// whatever a kill interrupts, after a restart a message is either in the journal and newer than its unit, and is
/// handed out again, or its samples are, or it has been published.
///
/// ```
/// # use fd_model::file::LinearModel;
/// use fd_watch::{Learning, Monitor, Request, StateFolder};
///
/// # let text = r#"
/// # version = 1
/// # kind = "state-space"
/// # sample_time = 1.0
/// # inputs = [{ name = "u" }]
/// # outputs = [{ name = "y" }]
/// # matrices = { A = [[0.9]], B = [[0.1]], C = [[1.0]], D = [[0.0]] }
/// # "#;
/// # let model = LinearModel::parse("model.toml", text)?;
/// # let folder = tempfile::tempdir()?;
/// let mut monitor = Monitor::new(Request::new(model, Learning::Stream { samples: 600 }).plan()?);
/// let (state, unsure) = StateFolder::open(folder.path(), &mut monitor)?;
/// assert!(unsure.is_empty());
/// // Two monitors on one state would destroy it.
/// assert!(StateFolder::open(folder.path(), &mut monitor).is_err());
/// # drop(state);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct StateFolder {
    folder: PathBuf,
    units: PathBuf,
    identity: Identity,
    journal: Journal,
    /// Held until the end.
    _lock: File,
}

/// The state cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StateError {
    /// The operating system does not let a file be read or written.
    #[error("cannot {action} {}: {source}", path.display())]
    Io {
        /// What was to be done.
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// Why not.
        source: io::Error,
    },
    /// Another monitor runs on it.
    #[error("{}: another monitor runs on this state", path.display())]
    Locked {
        /// The folder.
        path: PathBuf,
    },
    /// It belongs to something else.
    #[error(
        "{}: the state was made with another {what} ({found}, now {expected}); choose another folder, or \
         remove this one to begin anew", path.display()
    )]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What differs.
        what: &'static str,
        /// What is expected.
        expected: String,
        /// What is there.
        found: String,
    },
    /// A file is not what was saved.
    #[error("{}: {reason}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// A unit cannot be put back.
    #[error("{}: {source}", path.display())]
    Memory {
        /// Its file.
        path: PathBuf,
        /// Why.
        source: Box<MemoryError>,
    },
}

/// A file of the state.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Kept<T> {
    format: u32,
    identity: Identity,
    content: T,
}

fn io_error(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> StateError {
    let path = path.to_owned();
    move |source| StateError::Io { action, path, source }
}

impl StateFolder {
    /// Opens a state, or makes a new one, and puts all its units back into `monitor`. Returns the messages that
    /// may not have been published before the end of the last run: they are to be published first.
    ///
    /// # Errors
    ///
    /// Returns an error when another monitor runs on the state, when it belongs to another version, model, spec
    /// or healthy samples, or when a file is damaged.
    pub fn open(folder: &Path, monitor: &mut Monitor) -> Result<(Self, Vec<Message>), StateError> {
        let units = folder.join("units");
        fs::create_dir_all(&units).map_err(io_error("make", &units))?;
        let lock = lock(folder)?;
        let identity = monitor.plan().identity.clone();
        let owner = folder.join("state.json");
        if owner.exists() {
            read::<()>(&owner, &identity)?;
        } else {
            let kept = Kept { format: FORMAT, identity: identity.clone(), content: () };
            sealed::write(&owner, &kept).map_err(io_error("write", &owner))?;
            sync(folder)?;
        }
        let mut times = HashMap::new();
        for entry in fs::read_dir(&units).map_err(io_error("read", &units))? {
            let path = entry.map_err(io_error("read", &units))?.path();
            if path.extension().is_none_or(|extension| extension != "unit") {
                continue;
            }
            let memory: UnitMemory = read(&path, &identity)?;
            let rows = path.with_extension("rows");
            let learned: Option<LearnedRows> =
                memory.needs_learned().then(|| read(&rows, &identity)).transpose()?;
            times.insert(memory.unit().to_owned(), memory.time());
            let source = |source| StateError::Memory { path, source: Box::new(source) };
            monitor.restore(memory, learned).map_err(source)?;
        }
        let path = folder.join("journal.ndjson");
        let is_unsure = |message: &Message| {
            let saved = message.unit().and_then(|unit| *times.get(unit)?);
            saved.is_none_or(|saved| message.time().is_none_or(|time| saved < time))
        };
        let Found { journal, unsure } =
            Journal::open(&path, is_unsure).map_err(|error| match error {
                JournalError::Io(source) => io_error("open", &path)(source),
                JournalError::Line(line, reason) => StateError::Damaged {
                    path: path.clone(),
                    reason: format!("line {line}: {reason}"),
                },
            })?;
        sync(folder)?;
        let state = Self { folder: folder.to_owned(), units, identity, journal, _lock: lock };
        Ok((state, unsure))
    }

    /// Leaves out what was published before, and puts alarms into the journal: when this returns they are on
    /// the disk, and may be published.
    ///
    /// # Errors
    ///
    /// Returns an error when the disk is full or fails. Nothing of these messages may be published then; their
    /// units have not been saved, so they will come again when their samples do.
    pub fn promise(&mut self, messages: &mut Vec<Message>) -> Result<(), StateError> {
        messages.retain(|message| !self.journal.is_known(message));
        let alarms = messages.iter().filter(|message| message.key().is_some());
        let journal = self.folder.join("journal.ndjson");
        self.journal.append(alarms).map_err(io_error("write", &journal))
    }

    /// Saves at most so many units of a monitor, those that have waited longest. Everything that the monitor has
    /// said must have been published.
    ///
    /// # Errors
    ///
    /// Returns the first file that cannot be written; its unit waits to be saved again.
    pub fn save(&mut self, monitor: &mut Monitor, most: usize) -> Result<usize, StateError> {
        let mut saved = 0;
        while saved < most
            && let Some((memory, learned)) = monitor.next_to_save()
        {
            let path = self.units.join(format!("{}.unit", file_name(memory.unit())));
            if let Err(error) = self.save_one(&path, &memory, learned.as_ref()) {
                monitor.not_saved(&memory, learned);
                return Err(error);
            }
            saved += 1;
        }
        if 0 < saved {
            sync(&self.units)?;
        }
        Ok(saved)
    }

    fn save_one(
        &self,
        path: &Path,
        memory: &UnitMemory,
        learned: Option<&LearnedRows>,
    ) -> Result<(), StateError> {
        if let Some(learned) = learned {
            // Before the memory that needs it.
            let rows = path.with_extension("rows");
            self.write(&rows, learned)?;
            sync(&self.units)?;
        }
        self.write(path, memory)
    }

    fn write(&self, path: &Path, content: &impl Serialize) -> Result<(), StateError> {
        let kept = Kept { format: FORMAT, identity: self.identity.clone(), content };
        sealed::write(path, &kept).map_err(io_error("write", path))
    }
}

/// The lock of a folder, held as long as the file is open: the system gives it back when a process is killed.
fn lock(folder: &Path) -> Result<File, StateError> {
    let path = folder.join("lock");
    let file = File::create(&path).map_err(io_error("make", &path))?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(StateError::Locked { path: folder.to_owned() }),
        Err(TryLockError::Error(source)) => Err(io_error("lock", &path)(source)),
    }
}

fn read<T: serde::de::DeserializeOwned>(path: &Path, identity: &Identity) -> Result<T, StateError> {
    let damaged = |reason| StateError::Damaged { path: path.to_owned(), reason };
    let kept: Kept<T> = sealed::read(path).map_err(damaged)?;
    let foreign = |what, expected: &str, found: &str| StateError::Foreign {
        path: path.to_owned(),
        what,
        expected: expected.to_owned(),
        found: found.to_owned(),
    };
    if kept.format != FORMAT {
        return Err(foreign("format", &FORMAT.to_string(), &kept.format.to_string()));
    }
    match identity.differs(&kept.identity) {
        Some((what, expected, found)) => Err(foreign(what, expected, found)),
        None => Ok(kept.content),
    }
}

/// Makes renamed files last.
fn sync(folder: &Path) -> Result<(), StateError> {
    let synced = File::open(folder).and_then(|folder| folder.sync_all());
    synced.map_err(io_error("sync", folder))
}

/// A file name for any name of a unit: letters, digits, `-` and `_` as they are, other bytes as `%XX`; the end of a
/// long one as a sum.
fn file_name(unit: &str) -> String {
    let mut name = String::new();
    for byte in unit.bytes() {
        if byte.is_ascii_alphanumeric() || byte == b'-' || byte == b'_' {
            name.push(char::from(byte));
        } else {
            // Writing to a text does not fail.
            let _ = write!(name, "%{byte:02X}");
        }
    }
    if name.len() <= LONGEST_NAME {
        return name;
    }
    let mut sum = sealed::Sum::default();
    sum.add(unit.as_bytes());
    name.truncate(LONGEST_NAME);
    format!("{name}~{sum}")
}
