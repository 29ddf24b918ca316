//! The journal of alarms: on the disk before anybody hears of them.

use std::{
    collections::HashSet,
    fs::{File, OpenOptions},
    io::{self, BufRead, BufReader, Seek, SeekFrom, Write},
    path::Path,
};

use crate::message::Message;

/// An append-only file of messages, one per line.
#[derive(Debug)]
pub(super) struct Journal {
    file: File,
    /// Bytes that are known to be whole lines on the disk.
    length: u64,
    /// Messages that are newer than the memory of their unit: they will come again when samples are replayed.
    again: HashSet<String>,
}

/// What was found in a journal.
pub(super) struct Found {
    pub journal: Journal,
    /// Messages that may not have been published, in order.
    pub unsure: Vec<Message>,
}

/// Why a journal cannot be opened.
pub(super) enum JournalError {
    Io(io::Error),
    Line(u64, String),
}

impl From<io::Error> for JournalError {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

impl Journal {
    /// Opens or makes a journal. `is_unsure` says whether a message is newer than what was saved of its unit.
    pub(super) fn open(
        path: &Path,
        is_unsure: impl Fn(&Message) -> bool,
    ) -> Result<Found, JournalError> {
        let mut options = OpenOptions::new();
        let file = options.read(true).write(true).create(true).truncate(false).open(path)?;
        let mut reader = BufReader::new(&file);
        let (mut length, mut number, mut unsure) = (0_u64, 0, Vec::new());
        let mut line = Vec::new();
        loop {
            line.clear();
            let read = reader.read_until(b'\n', &mut line)?;
            // A line without an end was cut off by a kill: it was not promised.
            if line.last() != Some(&b'\n') {
                break;
            }
            number += 1;
            length += read as u64;
            let message: Message = serde_json::from_slice(&line)
                .map_err(|error| JournalError::Line(number, error.to_string()))?;
            if is_unsure(&message) {
                unsure.push(message);
            }
        }
        let again = unsure.iter().filter_map(Message::key).collect();
        let mut journal = Self { file, length, again };
        journal.cut()?;
        Ok(Found { journal, unsure })
    }

    /// Bytes of whole lines that are on the disk.
    pub(super) fn length(&self) -> u64 {
        self.length
    }

    /// Forgets what is not a whole line.
    fn cut(&mut self) -> io::Result<()> {
        self.file.set_len(self.length)?;
        self.file.seek(SeekFrom::Start(self.length))?;
        Ok(())
    }

    /// Whether a message was published before, in the replay of its samples.
    pub(super) fn is_known(&mut self, message: &Message) -> bool {
        !self.again.is_empty() && message.key().is_some_and(|key| self.again.remove(&key))
    }

    /// Appends messages and waits until they are on the disk.
    pub(super) fn append<'a>(
        &mut self,
        messages: impl Iterator<Item = &'a Message>,
    ) -> io::Result<()> {
        let mut lines = String::new();
        for message in messages {
            lines.push_str(&message.to_json());
            lines.push('\n');
        }
        if lines.is_empty() {
            return Ok(());
        }
        let written = self.file.write_all(lines.as_bytes()).and_then(|()| self.file.sync_data());
        if let Err(error) = written {
            // What is there of them was not promised.
            let _ = self.cut();
            return Err(error);
        }
        self.length += lines.len() as u64;
        Ok(())
    }
}
