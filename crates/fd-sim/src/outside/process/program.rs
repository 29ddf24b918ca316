//! A program that is a simulator: how it is started.

use std::{path::PathBuf, time::Duration};

use super::{super::stated::Stated, note::Note};

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
    pub(super) note: Note,
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

    /// What it is called in messages.
    pub(super) fn shown(&self) -> String {
        self.title.clone().unwrap_or_else(|| self.command.join(" "))
    }
}
