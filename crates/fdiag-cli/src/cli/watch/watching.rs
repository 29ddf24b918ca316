//! The loop: lines in, alarms on the disk, then out, then units saved.

use std::{
    io::Write,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
        mpsc::{Receiver, RecvTimeoutError},
    },
    time::{Duration, Instant},
};

use fd_watch::{Event, Format, Message, Monitor, RowReader, StateFolder};

use super::{
    super::failure::Failure,
    failures,
    feed::{Chunk, LONGEST_LINE},
    pulse::Pulse,
};

/// How long the loop waits for lines before it looks after everything else.
const BEAT: Duration = Duration::from_millis(100);
/// Longest that a round of saving may keep samples waiting.
const SAVING: Duration = Duration::from_millis(10);

/// A monitor at work.
pub(super) struct Watching<W> {
    pub(super) monitor: Monitor,
    pub(super) rows: RowReader,
    pub(super) format: Format,
    pub(super) state: Option<StateFolder>,
    pub(super) out: W,
    pub(super) pulse: Pulse,
    pub(super) stop: Arc<AtomicBool>,
    /// Told on standard error once, until saving works again.
    pub(super) cannot_save: bool,
    /// Time between two rounds of saving.
    pub(super) save_every: Duration,
}

impl<W: Write> Watching<W> {
    /// Runs until the input ends or somebody wants it to stop.
    pub(super) fn run(&mut self, feed: &Receiver<Chunk>) -> Result<(), Failure> {
        let mut saved = Instant::now();
        loop {
            if self.stop.load(Ordering::Relaxed) {
                return self.finish();
            }
            match feed.recv_timeout(BEAT) {
                Ok(Chunk::Lines(lines, read)) => {
                    let before = self.monitor.counts().rows;
                    let count = self.lines(&lines)?;
                    self.publish()?;
                    self.pulse.beat(read, count, self.monitor.counts().rows - before);
                }
                Ok(Chunk::TooLong) => {
                    self.rows.skip_long_line(LONGEST_LINE);
                    self.tell_faults();
                }
                Ok(Chunk::Rest(line)) => {
                    self.rest(&line)?;
                }
                Ok(Chunk::Failed(error)) => {
                    self.publish()?;
                    self.finish()?;
                    return Err(Failure::of_input(format!("the input cannot be read: {error}")));
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return self.finish(),
            }
            self.publish()?;
            self.pulse.look(&self.monitor, self.cannot_save);
            if self.save_every <= saved.elapsed() {
                self.save(SAVING);
                saved = Instant::now();
            }
        }
    }

    /// Judges lines, and returns how many there were.
    fn lines(&mut self, lines: &[u8]) -> Result<u64, Failure> {
        let mut count = 0;
        for line in lines.split_inclusive(|byte| *byte == b'\n') {
            count += 1;
            let has_row = self.rows.read(line).map_err(Failure::of_input)?;
            if has_row {
                self.monitor.take(self.rows.row()).map_err(Failure::analysis)?;
            }
            self.tell_faults();
        }
        Ok(count)
    }

    /// A last line without an end: JSON shows whether it is whole, a number of a CSV does not.
    fn rest(&mut self, line: &[u8]) -> Result<u64, Failure> {
        match self.format {
            Format::Ndjson => self.lines(line),
            Format::Csv => self.lines(b"\"cut off\n"),
        }
    }

    fn tell_faults(&mut self) {
        for what in self.rows.take_events() {
            self.monitor.tell(Event { unit: None, time: None, what });
        }
    }

    /// Says what is to be said: first to the disk, then to the world.
    fn publish(&mut self) -> Result<(), Failure> {
        if !self.monitor.has_messages() {
            return Ok(());
        }
        let mut messages = self.monitor.take_messages();
        if let Some(state) = &mut self.state {
            state.promise(&mut messages).map_err(failures::of_state)?;
        }
        self.say(&messages)
    }

    /// Writes messages, and sees to it that they have left.
    pub(super) fn say(&mut self, messages: &[Message]) -> Result<(), Failure> {
        let mut write = || -> std::io::Result<()> {
            for message in messages {
                writeln!(self.out, "{}", message.to_json())?;
            }
            self.out.flush()
        };
        // A reader that is gone is a failure here: nobody would hear of an alarm.
        write().map_err(|error| Failure::output("standard output", error))?;
        self.pulse.say(messages);
        Ok(())
    }

    /// Saves units for at most so long; what is left waits for the next round.
    fn save(&mut self, longest: Duration) {
        let Some(state) = &mut self.state else { return };
        let begun = Instant::now();
        while 0 < self.monitor.to_save() {
            match state.save(&mut self.monitor, 1) {
                Ok(_) => self.cannot_save = false,
                Err(error) => {
                    if !std::mem::replace(&mut self.cannot_save, true) {
                        eprintln!(
                            "fdiag: {error}; the monitor goes on, and tries again every second"
                        );
                    }
                    return;
                }
            }
            if longest <= begun.elapsed() {
                return;
            }
        }
    }

    fn finish(&mut self) -> Result<(), Failure> {
        self.publish()?;
        if let Some(state) = &mut self.state {
            state.save(&mut self.monitor, usize::MAX).map_err(failures::of_state)?;
        }
        Ok(())
    }
}
