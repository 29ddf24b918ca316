//! A child process whose every answer is waited for with a limit.

use std::{
    collections::VecDeque,
    io::{ErrorKind, Read, Write},
    os::{fd::AsFd, unix::process::CommandExt},
    path::{Path, PathBuf},
    process::{self, ChildStderr, ChildStdin, ChildStdout, Command, Stdio},
    sync::{Arc, Condvar, Mutex, PoisonError},
    time::{Duration, Instant},
};

use rustix::{
    event::{PollFd, PollFlags, Timespec, poll},
    io::{Errno, ioctl_fionbio},
};

use super::{
    super::{error::OutsideError, leftovers, lock::open, programs},
    note::{Lines, Note, is_note},
    program::Process,
};

/// Longest line of a hello, in bytes.
const LONGEST_LINE: usize = 1 << 20;
/// What is kept of standard error, in bytes, and shown of it, in lines.
const LAST_BYTES: usize = 4096;
const LAST_LINES: usize = 8;
/// How long it is waited for the status and the last words of a process that has closed its output, and for one
/// that was told that it is over.
const FAREWELL: Duration = Duration::from_millis(300);
/// How often it is looked then.
const LOOK: Duration = Duration::from_millis(2);

/// A running child; it is ended when this is dropped, with all that it has started.
#[derive(Debug)]
pub(super) struct Child {
    running: process::Child,
    input: Option<ChildStdin>,
    output: ChildStdout,
    words: Arc<Words>,
    shown: String,
    timeout: Duration,
}

/// The end of standard error.
#[derive(Debug, Default)]
struct Words {
    last: Mutex<(VecDeque<u8>, bool)>,
    /// Rung when standard error has ended.
    ended: Condvar,
}

impl Words {
    fn listen(&self, mut from: ChildStderr, note: Note) {
        let (mut buffer, mut lines) = ([0; 1024], Lines::new(note));
        loop {
            match from.read(&mut buffer) {
                Ok(n) if 0 < n => {
                    lines.take(&buffer[..n]);
                    let mut last = open(&self.last);
                    last.0.extend(&buffer[..n]);
                    let surplus = last.0.len().saturating_sub(LAST_BYTES);
                    last.0.drain(..surplus);
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                _ => break,
            }
        }
        drop(lines);
        open(&self.last).1 = true;
        self.ended.notify_all();
    }

    /// The last lines; waits a little for the end if the process is no more.
    fn last(&self, patience: Duration) -> String {
        let last = open(&self.last);
        let waited = self.ended.wait_timeout_while(last, patience, |last| !last.1);
        let last = waited.unwrap_or_else(PoisonError::into_inner).0;
        let (front, back) = last.0.as_slices();
        let text = String::from_utf8_lossy(&[front, back].concat()).into_owned();
        let are_words = |line: &&str| !line.trim().is_empty() && !is_note(line);
        let lines: Vec<&str> = text.lines().filter(are_words).collect();
        lines[lines.len().saturating_sub(LAST_LINES)..].join("\n")
    }
}

/// A program with a directory in its name is meant from the directory of the model on.
fn program(name: &str, directory: &Path) -> PathBuf {
    let path = Path::new(name);
    if path.is_relative() && name.contains('/') { directory.join(path) } else { path.to_owned() }
}

impl Child {
    /// Starts a process.
    pub(super) fn start(process: &Process) -> Result<Self, OutsideError> {
        let shown = process.shown();
        let failed = |message: String| OutsideError::Start { command: shown.clone(), message };
        let (name, arguments) =
            process.command.split_first().ok_or_else(|| failed("it is empty".to_owned()))?;
        let directory = std::path::absolute(&process.directory);
        let directory = directory.map_err(|e| failed(e.to_string()))?;
        programs::check(&directory.display().to_string(), || format!("`{shown}`"))?;
        let mut child = Command::new(program(name, &directory))
            .args(arguments)
            .current_dir(&directory)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            // A group of its own, so that what it starts can be ended with it.
            .process_group(0)
            .spawn()
            .map_err(|e| failed(format!("{e} (in {})", directory.display())))?;
        leftovers::started(child.id());
        let pipes = (child.stdin.take(), child.stdout.take(), child.stderr.take());
        let (Some(input), Some(output), Some(error)) = pipes else {
            return Err(failed("it has no pipes".to_owned()));
        };
        // A child that does not read must not stop this program.
        ioctl_fionbio(&input, true).map_err(|e| failed(e.to_string()))?;
        let words = Arc::new(Words::default());
        let (listener, note) = (Arc::clone(&words), process.note.clone());
        std::thread::spawn(move || listener.listen(error, note));
        Ok(Self {
            running: child,
            input: Some(input),
            output,
            words,
            shown,
            timeout: process.timeout,
        })
    }

    /// Sends all bytes.
    pub(super) fn send(
        &mut self,
        bytes: &[u8],
        what: &str,
        deadline: Instant,
    ) -> Result<(), OutsideError> {
        let mut sent = 0;
        while sent < bytes.len() {
            let Some(input) = &mut self.input else { return Err(self.ended(what)) };
            match input.write(&bytes[sent..]) {
                Ok(0) => return Err(self.ended(what)),
                Ok(n) => sent += n,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) if error.kind() == ErrorKind::WouldBlock => {
                    if !wait(&*input, PollFlags::OUT, deadline) {
                        return Err(self.silent(what));
                    }
                }
                Err(_) => return Err(self.ended(what)),
            }
        }
        Ok(())
    }

    /// Receives as many bytes as there is room for, at least one.
    fn receive_some(
        &mut self,
        buffer: &mut [u8],
        what: &str,
        deadline: Instant,
    ) -> Result<usize, OutsideError> {
        loop {
            if !wait(&self.output, PollFlags::IN, deadline) {
                return Err(self.silent(what));
            }
            match self.output.read(buffer) {
                Ok(n) if 0 < n => return Ok(n),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                _ => return Err(self.ended(what)),
            }
        }
    }

    /// Fills the buffer.
    pub(super) fn receive(
        &mut self,
        buffer: &mut [u8],
        what: &str,
        deadline: Instant,
    ) -> Result<(), OutsideError> {
        let mut got = 0;
        while got < buffer.len() {
            got += self.receive_some(&mut buffer[got..], what, deadline)?;
        }
        Ok(())
    }

    /// A line, without its end.
    pub(super) fn receive_line(
        &mut self,
        what: &str,
        deadline: Instant,
    ) -> Result<Vec<u8>, OutsideError> {
        let mut line = Vec::new();
        let mut buffer = [0; 4096];
        loop {
            let n = self.receive_some(&mut buffer, what, deadline)?;
            line.extend_from_slice(&buffer[..n]);
            if let Some(end) = line.iter().position(|byte| *byte == b'\n') {
                let surplus = line.len() - end - 1;
                line.truncate(end);
                if 0 < surplus {
                    let text = String::from_utf8_lossy(&line).into_owned();
                    let found = format!("{surplus} bytes more after the line `{}`", brief(&text));
                    let expected = "one line, and then nothing until it is asked (what is for \
                                    people belongs on standard error)";
                    return Err(self.protocol(what, expected.to_owned(), found));
                }
                return Ok(line);
            }
            if LONGEST_LINE < line.len() {
                let found = format!("{} bytes without the end of a line", line.len());
                return Err(self.protocol(what, "a line of JSON".to_owned(), found));
            }
        }
    }

    /// When an answer to what is asked now is overdue.
    pub(super) fn deadline(&self) -> Instant {
        // A limit of centuries is none.
        let century = Duration::from_secs(100 * 365 * 86400);
        Instant::now() + self.timeout.min(century)
    }

    /// Something else has come than the protocol says.
    pub(super) fn protocol(&self, what: &str, expected: String, found: String) -> OutsideError {
        let last_words = self.words.last(Duration::ZERO);
        let (command, what) = (self.shown.clone(), what.to_owned());
        OutsideError::Protocol { command, what, expected, found, last_words }
    }

    fn silent(&self, what: &str) -> OutsideError {
        let last_words = self.words.last(Duration::ZERO);
        let (command, seconds) = (self.shown.clone(), self.timeout.as_secs_f64());
        OutsideError::Silent { command, what: what.to_owned(), seconds, last_words }
    }

    fn ended(&mut self, what: &str) -> OutsideError {
        let status = self.await_end(FAREWELL);
        let status = status.unwrap_or_else(|| "it has closed its standard output".to_owned());
        let last_words = self.words.last(FAREWELL);
        let (command, what) = (self.shown.clone(), what.to_owned());
        OutsideError::Ended { command, what, status, last_words }
    }

    fn await_end(&mut self, patience: Duration) -> Option<String> {
        let begun = Instant::now();
        loop {
            match self.running.try_wait() {
                Ok(Some(status)) => return Some(status.to_string()),
                Ok(None) if begun.elapsed() < patience => std::thread::sleep(LOOK),
                _ => return None,
            }
        }
    }

    /// Closes its standard input, and gives it a moment to end by itself.
    pub(super) fn farewell(&mut self) {
        self.input = None;
        self.await_end(FAREWELL);
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        self.input = None;
        leftovers::end(self.running.id());
        self.await_end(FAREWELL);
        leftovers::ended(self.running.id());
    }
}

/// Waits until a pipe is ready, or closed; `false` when it takes too long.
fn wait(pipe: &impl AsFd, flags: PollFlags, deadline: Instant) -> bool {
    loop {
        let left = deadline.saturating_duration_since(Instant::now());
        let limit = Timespec::try_from(left).ok();
        match poll(&mut [PollFd::new(pipe, flags)], limit.as_ref()) {
            Ok(0) => return false,
            Err(Errno::INTR) => {}
            // What is wrong with it shows when it is used.
            Ok(_) | Err(_) => return true,
        }
    }
}

/// The beginning of a text, for messages.
pub(super) fn brief(text: &str) -> String {
    const MOST: usize = 80;
    let text = text.trim();
    if text.chars().count() <= MOST {
        return text.to_owned();
    }
    text.chars().take(MOST).chain("...".chars()).collect()
}
