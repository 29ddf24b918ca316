//! A separate program as a simulator, over its standard input and output.
//!
//! Each direction begins with a line of JSON, the *hello*: what the file says about the simulator, and what the
//! simulator says about itself. Then binary frames go back and forth. `docs/process-protocol.md` describes
//! both.
//!
//! *When not to use:* on systems other than Unix, where waiting for a pipe with a timeout needs other means; a
//! process is refused there.

mod child;
mod frame;
mod hello;
mod instance;
mod note;
mod serve;
#[cfg(feature = "fmu")]
mod streams;

use std::{path::PathBuf, time::Duration};

pub use self::serve::{serve, stated};
use self::{instance::ProcessInstance, note::Note};
#[cfg(feature = "fmu")]
pub(super) use self::{
    note::{tell, tell_in_case_of_an_end},
    serve::{Widths, answer, greet, heard},
    streams::own_streams,
};
use super::{
    contract::{Contract, Stated},
    error::OutsideError,
    source::{Instance, Source},
};

/// Version of the protocol that this program speaks.
pub const PROTOCOL_VERSION: u32 = 1;

/// How a simulator is started as a process, and how long it may take.
///
/// ```
/// use fd_sim::outside::Process;
///
/// // A program that is not there is said so when it is asked what it is.
/// let missing = Process::new(["./no-such-simulator"]);
/// assert!(missing.contract().unwrap_err().to_string().contains("cannot be started"));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Process {
    /// The program and its arguments. A program with a `/` in it is sought from the directory on.
    pub command: Vec<String>,
    /// The directory that it runs in.
    pub directory: PathBuf,
    /// The longest time that an answer may take: to the hello, a step, or a whole run.
    pub timeout: Duration,
    /// What the user says of it; it is told in the hello, and may say itself what is left out.
    pub stated: Stated,
    /// What it is called in messages, if not by its command.
    pub title: Option<String>,
    /// What one of them has told its user.
    note: Note,
}

impl Process {
    /// A program that says itself what it is, with 30 s for an answer.
    #[must_use]
    pub fn new<S: Into<String>>(command: impl IntoIterator<Item = S>) -> Self {
        Self {
            command: command.into_iter().map(Into::into).collect(),
            directory: PathBuf::from("."),
            timeout: Duration::from_secs(30),
            stated: Stated::default(),
            title: None,
            note: Note::default(),
        }
    }

    /// Starts it once and asks what it is.
    ///
    /// # Errors
    ///
    /// Returns why it cannot be started, or what is wrong with its hello.
    pub fn contract(&self) -> Result<Contract, OutsideError> {
        Ok(ProcessInstance::open(self)?.1)
    }

    /// What it is called in messages.
    fn shown(&self) -> String {
        self.title.clone().unwrap_or_else(|| self.command.join(" "))
    }
}

impl Source for Process {
    fn open(&self) -> Result<Box<dyn Instance>, OutsideError> {
        Ok(Box::new(ProcessInstance::open(self)?.0))
    }

    fn note(&self) -> Option<String> {
        self.note.get()
    }
}
