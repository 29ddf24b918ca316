//! The folder as a whole.

use std::{
    collections::{HashMap, hash_map::RandomState},
    fmt::Write as _,
    fs::{self, File, TryLockError},
    hash::{BuildHasher, Hasher},
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};

use super::{
    Identity, Outbox, StateError,
    error::io_error,
    intake::{self, Intake, ReadError},
    journal::{Found, Journal, JournalError},
    sealed,
};
use crate::{
    input::Row,
    memory::{LearnedRows, UnitMemory},
    message::Message,
    monitor::Monitor,
};

/// Version of the way in which states are kept.
const FORMAT: u32 = 3;
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
    intake: Intake,
    /// Units saved so far.
    savings: u64,
    /// Held until the end.
    _lock: File,
}

/// A file of the state.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Kept<T> {
    format: u32,
    identity: Identity,
    content: T,
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
        let samples = folder.join("samples");
        let intake = Intake::open(samples.clone()).map_err(io_error("open", &samples))?;
        sync(folder)?;
        let folder = folder.to_owned();
        let state = Self { folder, units, identity, journal, intake, savings: 0, _lock: lock };
        Ok((state, unsure))
    }

    /// Hands out the samples that were kept and may be newer than the memory of their unit, oldest first. To be called
    /// once, before other samples are taken; `take` gives them to the monitor. Returns the first error of `take`.
    ///
    /// # Errors
    ///
    /// Returns an error when they cannot be read.
    pub fn replay<E>(
        &mut self,
        monitor: &mut Monitor,
        mut take: impl FnMut(&mut Monitor, Row<'_>) -> Result<(), E>,
    ) -> Result<Result<(), E>, StateError> {
        for path in self.intake.left() {
            let read =
                intake::read(&path, |row| take(monitor, row)).map_err(|error| match error {
                    ReadError::Io(source) => io_error("read", &path)(source),
                    ReadError::Line(line, reason) => StateError::Damaged {
                        path: path.clone(),
                        reason: format!("line {line}: {reason}"),
                    },
                })?;
            if read.is_err() {
                return Ok(read);
            }
        }
        self.intake.replayed(self.savings + monitor.to_save() as u64);
        Ok(Ok(()))
    }

    /// Notes a sample that a source will be told to forget, after [`StateFolder::secure`].
    pub fn keep(&mut self, row: Row<'_>) {
        self.intake.add(row);
    }

    /// Puts noted samples on the disk: when this returns their source may forget them. The monitor must have taken
    /// them.
    ///
    /// # Errors
    ///
    /// Returns an error when the disk is full or fails; the samples are written with the next ones.
    pub fn secure(&mut self, monitor: &Monitor) -> Result<(), StateError> {
        let needed = self.savings + monitor.to_save() as u64;
        let samples = self.folder.join("samples");
        self.intake.secure(needed).map_err(io_error("write", &samples))
    }

    /// Bytes of the journal that are promised.
    #[must_use]
    pub fn promised(&self) -> u64 {
        self.journal.length()
    }

    /// A name that no other state has: made when it is first asked for, and kept.
    ///
    /// # Errors
    ///
    /// Returns an error when it cannot be written or is damaged.
    pub fn name(&self) -> Result<String, StateError> {
        let path = self.folder.join("name.json");
        if path.exists() {
            let damaged = |reason| StateError::Damaged { path: path.clone(), reason };
            return sealed::read(&path).map_err(damaged);
        }
        // The keys of a hash table are random, and other ones in each process.
        let name = format!("{:016x}", RandomState::new().build_hasher().finish());
        sealed::write(&path, &name).map_err(io_error("write", &path))?;
        Ok(name)
    }

    /// What a second listener has not yet confirmed of the journal.
    ///
    /// # Errors
    ///
    /// Returns an error when the file that says so is damaged.
    pub fn outbox(&self) -> Result<Outbox, StateError> {
        Outbox::open(&self.folder, self.promised())
            .map_err(|(path, reason)| StateError::Damaged { path, reason })
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

    /// Saves the unit whose question was answered, see [`Monitor::answer`]. Everything that the monitor has said must
    /// have been published.
    ///
    /// # Errors
    ///
    /// As [`StateFolder::save`].
    pub fn save_answered(&mut self, monitor: &mut Monitor) -> Result<(), StateError> {
        // It has been put before the others.
        self.intake.keep_until(self.savings + monitor.to_save() as u64);
        self.save(monitor, 1).map(drop)
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
                self.intake.keep_until(self.savings + saved as u64 + monitor.to_save() as u64);
                return Err(error);
            }
            saved += 1;
        }
        if 0 < saved {
            sync(&self.units)?;
            self.savings += saved as u64;
        }
        if monitor.to_save() == 0 {
            // Everything that came is in the memory of its unit.
            self.intake.close(self.savings);
        }
        self.intake.clean(self.savings);
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
