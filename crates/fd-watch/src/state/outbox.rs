//! How far a second listener has heard of the journal: a place in it, kept in a file.

use std::{
    fs::File,
    io::{self, BufRead, BufReader, Seek, SeekFrom},
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};

use super::sealed;
use crate::message::Message;

/// Promised messages for a listener that may be away for long, such as a broker: they stay in the journal until it has
/// confirmed them, and are handed out again after a restart.
///
/// ```
/// # use fd_model::file::LinearModel;
/// # use fd_watch::{Learning, Monitor, Request, StateFolder};
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
/// # let mut monitor = Monitor::new(Request::new(model, Learning::Stream { samples: 600 }).plan()?);
/// let (state, _) = StateFolder::open(folder.path(), &mut monitor)?;
/// let mut outbox = state.outbox()?;
/// assert!(outbox.next(state.promised(), 100)?.is_empty());
/// outbox.confirm()?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Outbox {
    journal: PathBuf,
    path: PathBuf,
    /// Confirmed up to here, and handed out up to there.
    at: u64,
    ahead: u64,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Place {
    bytes: u64,
}

impl Outbox {
    /// The place in a journal of this length. A journal that is shorter has been moved away: it is heard from its
    /// beginning.
    pub(super) fn open(folder: &Path, length: u64) -> Result<Self, (PathBuf, String)> {
        let path = folder.join("outbox.json");
        let at = if path.exists() {
            let place: Place = sealed::read(&path).map_err(|reason| (path.clone(), reason))?;
            if place.bytes <= length { place.bytes } else { 0 }
        } else {
            0
        };
        Ok(Self { journal: folder.join("journal.ndjson"), path, at, ahead: at })
    }

    /// Bytes of the journal that are confirmed.
    #[must_use]
    pub fn confirmed(&self) -> u64 {
        self.at
    }

    /// The next messages that are not confirmed, at most so many, from the `promised` bytes of the journal.
    ///
    /// # Errors
    ///
    /// Returns an error when the journal cannot be read.
    pub fn next(&mut self, promised: u64, most: usize) -> io::Result<Vec<Message>> {
        self.ahead = self.at;
        let mut messages = Vec::new();
        if promised <= self.at {
            return Ok(messages);
        }
        let mut file = File::open(&self.journal)?;
        file.seek(SeekFrom::Start(self.at))?;
        let mut reader = BufReader::new(file);
        let mut line = Vec::new();
        while messages.len() < most && self.ahead < promised {
            line.clear();
            let read = reader.read_until(b'\n', &mut line)?;
            if line.last() != Some(&b'\n') {
                break;
            }
            self.ahead += read as u64;
            messages.push(serde_json::from_slice(&line)?);
        }
        Ok(messages)
    }

    /// The messages that were handed out last have been heard.
    ///
    /// # Errors
    ///
    /// Returns an error when the place cannot be written: the messages will be handed out again after a restart.
    pub fn confirm(&mut self) -> io::Result<()> {
        if self.ahead == self.at {
            return Ok(());
        }
        self.at = self.ahead;
        sealed::write(&self.path, &Place { bytes: self.at })
    }
}
