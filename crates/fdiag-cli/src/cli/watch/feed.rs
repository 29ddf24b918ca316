//! Lines from wherever they come, read by a thread of its own so that the monitor never waits for them.

use std::{
    fs::File,
    io::{self, Read, Seek, SeekFrom},
    path::{Path, PathBuf},
    sync::mpsc::{Receiver, SyncSender, sync_channel},
    time::{Duration, Instant},
};

#[cfg(feature = "mqtt")]
use fd_watch::What;

#[cfg(feature = "mqtt")]
use super::mqtt::Delivery;

/// Bytes that are read at once.
const CHUNK: usize = 64 << 10;
/// Chunks that may wait: beyond them whoever writes has to wait.
const WAITING: usize = 16;
/// Longest line.
pub(super) const LONGEST_LINE: usize = 1 << 20;
/// How often a followed file is looked at.
const LOOK: Duration = Duration::from_millis(100);

/// What a feed brings.
pub(super) enum Chunk {
    /// Whole lines, and when they were read.
    Lines(Vec<u8>, Instant),
    /// A message of a broker.
    #[cfg(feature = "mqtt")]
    Delivered(Delivery),
    /// A broker was reached; what comes now may have come before.
    #[cfg(feature = "mqtt")]
    Connected(What),
    /// Something that is to be told of the source.
    #[cfg(feature = "mqtt")]
    Told(What),
    /// A line was longer than [`LONGEST_LINE`].
    TooLong,
    /// The last line has no end.
    Rest(Vec<u8>),
    /// The input cannot be read any more.
    Failed(io::Error),
}

/// Starts to read a stream to its end.
pub(super) fn stream(from: impl Read + Send + 'static) -> Receiver<Chunk> {
    let (sender, receiver) = sync_channel(WAITING);
    std::thread::spawn(move || read_lines(from, &sender));
    receiver
}

/// Starts to follow a file: what is appended to it, and the file that takes its place when it is moved away. There is
/// no end.
pub(super) fn follow(path: &Path) -> io::Result<Receiver<Chunk>> {
    let file = File::open(path)?;
    Ok(stream(Followed { path: path.to_owned(), file, at: 0 }))
}

fn read_lines(mut from: impl Read, sender: &SyncSender<Chunk>) {
    let mut buffer = vec![0; CHUNK];
    let mut rest: Vec<u8> = Vec::new();
    let mut skipping = false;
    loop {
        let read = match from.read(&mut buffer) {
            Ok(0) => break,
            Ok(read) => read,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(error) => {
                let _ = sender.send(Chunk::Failed(error));
                return;
            }
        };
        let mut new = &buffer[..read];
        if skipping {
            let Some(end) = new.iter().position(|byte| *byte == b'\n') else { continue };
            (new, skipping) = (&new[end + 1..], false);
        }
        let mut sent = Ok(());
        if let Some(end) = new.iter().rposition(|byte| *byte == b'\n') {
            let mut lines = std::mem::take(&mut rest);
            lines.extend_from_slice(&new[..=end]);
            new = &new[end + 1..];
            sent = sender.send(Chunk::Lines(lines, Instant::now()));
        }
        rest.extend_from_slice(new);
        // Whoever received has stopped.
        if sent.is_err() {
            return;
        }
        if LONGEST_LINE < rest.len() {
            rest.clear();
            skipping = true;
            if sender.send(Chunk::TooLong).is_err() {
                return;
            }
        }
    }
    if !rest.is_empty() {
        let _ = sender.send(Chunk::Rest(rest));
    }
}

/// A file that grows.
struct Followed {
    path: PathBuf,
    file: File,
    at: u64,
}

impl Followed {
    /// Whether another file has taken the place of this one, or this one was emptied.
    fn is_replaced(&self) -> bool {
        let Ok(now) = std::fs::metadata(&self.path) else { return false };
        let is_other = self.file.metadata().is_ok_and(|own| !is_same(&own, &now));
        is_other || now.len() < self.at
    }
}

#[cfg(unix)]
fn is_same(a: &std::fs::Metadata, b: &std::fs::Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}

#[cfg(not(unix))]
fn is_same(_: &std::fs::Metadata, _: &std::fs::Metadata) -> bool {
    true
}

impl Read for Followed {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            let read = self.file.read(buffer)?;
            if 0 < read {
                self.at += read as u64;
                return Ok(read);
            }
            if self.is_replaced() {
                self.file = File::open(&self.path)?;
                self.file.seek(SeekFrom::Start(0))?;
                self.at = 0;
                // What the old file ended with is a line of its own.
                buffer[0] = b'\n';
                return Ok(1);
            }
            std::thread::sleep(LOOK);
        }
    }
}
