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

use fd_watch::{Answer, Event, Format, Message, Monitor, RowReader, StateFolder};

#[cfg(feature = "mqtt")]
use super::brokers::Brokers;
use super::{
    super::{failure::Failure, say::complain},
    failures,
    feed::{Chunk, LONGEST_LINE},
    nightly::Nightly,
    pulse::Pulse,
    study::Studies,
};

/// How long the loop waits for lines before it looks after everything else.
const BEAT: Duration = Duration::from_millis(100);
/// Longest that a round of saving may keep samples waiting.
const SAVING: Duration = Duration::from_millis(10);

/// A monitor at work.
pub(super) struct Watching<W> {
    pub monitor: Monitor,
    pub rows: RowReader,
    pub format: Format,
    pub state: Option<StateFolder>,
    pub out: W,
    pub pulse: Pulse,
    #[cfg(feature = "mqtt")]
    pub brokers: Brokers,
    pub stop: Arc<AtomicBool>,
    /// Taken from the feed and not yet looked at.
    pub next: Option<Chunk>,
    /// What is done about units that have moved away from their model.
    pub diagnosing: Option<(Nightly, Studies)>,
    /// Whether it was told that some units cannot be studied.
    pub is_short: bool,
    /// Told on standard error once, until saving works again.
    pub cannot_save: bool,
    /// Time between two rounds of saving.
    pub save_every: Duration,
}

impl<W: Write> Watching<W> {
    /// Runs until the input ends or somebody wants it to stop.
    pub(super) fn run(&mut self, feed: &Receiver<Chunk>) -> Result<(), Failure> {
        let mut saved = Instant::now();
        loop {
            if self.stop.load(Ordering::Relaxed) {
                return self.finish();
            }
            let next = match self.next.take() {
                Some(chunk) => Ok(chunk),
                None => feed.recv_timeout(BEAT),
            };
            match next {
                #[cfg(feature = "mqtt")]
                Ok(Chunk::Delivered(first)) => self.deliveries(first, feed)?,
                #[cfg(feature = "mqtt")]
                Ok(Chunk::Connected(what)) => {
                    self.monitor.resume();
                    self.monitor.tell(Event { unit: None, time: None, what });
                }
                #[cfg(feature = "mqtt")]
                Ok(Chunk::Told(what)) => {
                    self.monitor.tell(Event { unit: None, time: None, what });
                }
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
            self.answers()?;
            #[cfg(feature = "mqtt")]
            self.replies()?;
            self.studied();
            #[cfg(feature = "mqtt")]
            self.sign();
            #[cfg(feature = "mqtt")]
            self.pulse.hears(self.brokers.behind());
            self.pulse.look(&self.monitor, self.cannot_save);
            if self.save_every <= saved.elapsed() {
                self.save(SAVING);
                saved = Instant::now();
            }
        }
    }

    /// Deals with what was answered on the page; an answer is kept before it is acknowledged.
    fn answers(&mut self) -> Result<(), Failure> {
        for answer in self.pulse.take_answers() {
            let Answer { id, confirmed, heard } = answer;
            let outcome = self.answer(&id, confirmed)?;
            // Whoever has left does not want to know.
            let _ = heard.try_send(outcome);
        }
        Ok(())
    }

    /// Acts on an answer and keeps it; in words, why that cannot be.
    pub(super) fn answer(
        &mut self,
        id: &str,
        confirmed: bool,
    ) -> Result<Result<(), String>, Failure> {
        if self.monitor.answer(id, confirmed).is_none() {
            return Ok(Err("nobody asks this any more".to_owned()));
        }
        self.publish()?;
        let kept = self.state.as_mut().map(|state| state.save_answered(&mut self.monitor));
        let lost = |error| format!("it acts now, and is lost at a restart: {error}");
        let kept = kept.unwrap_or(Ok(())).map_err(lost);
        #[cfg(feature = "mqtt")]
        self.brokers.settle();
        Ok(kept)
    }

    /// Judges lines, and returns how many there were.
    pub(super) fn lines(&mut self, lines: &[u8]) -> Result<u64, Failure> {
        let mut count = 0;
        for line in lines.split_inclusive(|byte| *byte == b'\n') {
            count += 1;
            let has_row = self.rows.read(line).map_err(Failure::of_input)?;
            if has_row {
                self.row()?;
            }
            self.tell_faults();
        }
        Ok(count)
    }

    /// Judges the row that was read last.
    pub(super) fn row(&mut self) -> Result<(), Failure> {
        let row = self.rows.row();
        self.monitor.take(row).map_err(Failure::analysis)?;
        if let Some((nightly, studies)) = &mut self.diagnosing
            && let Some(status) = self.monitor.unit(row.unit)
            && let Some(stretch) = nightly.take(row, status)
            && let Some(event) = studies.take(stretch)
        {
            self.monitor.tell(event);
        }
        Ok(())
    }

    /// What the studies have answered.
    fn studied(&mut self) {
        let Some((nightly, studies)) = &mut self.diagnosing else { return };
        if std::mem::take(&mut nightly.is_full) && !self.is_short {
            self.is_short = true;
            complain("fdiag: --diagnose: no room for recent samples of further units");
        }
        for event in studies.answers() {
            self.monitor.tell(event);
        }
    }

    /// A last line without an end: JSON shows whether it is whole, a number of a CSV does not.
    fn rest(&mut self, line: &[u8]) -> Result<u64, Failure> {
        match self.format {
            Format::Ndjson => self.lines(line),
            Format::Csv => self.lines(b"\"cut off\n"),
        }
    }

    pub(super) fn tell_faults(&mut self) {
        for what in self.rows.take_events() {
            self.monitor.tell(Event { unit: None, time: None, what });
        }
    }

    /// Says what is to be said: first to the disk, then to the world.
    pub(super) fn publish(&mut self) -> Result<(), Failure> {
        if !self.monitor.has_messages() {
            return Ok(());
        }
        let mut messages = self.monitor.take_messages();
        if let Some(state) = &mut self.state {
            state.promise(&mut messages).map_err(failures::of_state)?;
            #[cfg(feature = "mqtt")]
            self.brokers.promised(state.promised());
        }
        #[cfg(feature = "mqtt")]
        self.brokers.hear(&messages);
        self.say(&messages)
    }

    /// Takes again what a broker was told to forget and what no unit remembers.
    pub(super) fn replay(&mut self) -> Result<(), Failure> {
        let Some(state) = &mut self.state else { return Ok(()) };
        let taken = state.replay(&mut self.monitor, Monitor::take).map_err(failures::of_state)?;
        taken.map_err(failures::of_plan)?;
        self.publish()
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
                        complain(&format!(
                            "fdiag: {error}; the monitor goes on, and tries again every second"
                        ));
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
        #[cfg(feature = "mqtt")]
        self.brokers.finish();
        if let Some(state) = &mut self.state {
            state.save(&mut self.monitor, usize::MAX).map_err(failures::of_state)?;
        }
        Ok(())
    }
}
