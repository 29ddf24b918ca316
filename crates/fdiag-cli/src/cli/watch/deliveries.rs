//! Samples that a broker delivers, judged.

use std::{
    io::Write,
    sync::{atomic::Ordering, mpsc::Receiver},
};

use fd_watch::{Event, What};

use super::{
    super::{failure::Failure, say::complain},
    feed::{Chunk, LONGEST_LINE},
    mqtt::{Delivery, Receipt},
    watching::Watching,
};

/// Messages that are judged before their samples are put on the disk together, and their alarms are told.
const TOGETHER: usize = 1000;
/// So many lines are enough, however few messages they are; one message may have more, and what is said of it is told
/// in between: of lines that are none there is an event each.
const ENOUGH: u64 = 10_000;

impl<W: Write> Watching<W> {
    /// Judges a message and those that wait behind it.
    pub(super) fn deliveries(
        &mut self,
        first: Delivery,
        feed: &Receiver<Chunk>,
    ) -> Result<(), Failure> {
        let (oldest, rows) = (first.read, self.monitor.counts().rows);
        let (mut lines, mut next) = (0, first);
        for _ in 0..TOGETHER {
            let Delivery { unit, payload, receipt, room, .. } = next;
            // Nothing is promised of those without a receipt: they shall not fill the memory when the disk is full.
            let is_kept = receipt.is_some() || !self.cannot_save;
            lines += self.samples(unit.as_deref(), &payload, is_kept)?;
            if self.stop.load(Ordering::Relaxed) {
                // It may not have been judged to its end: without a receipt it comes again.
                return self.publish();
            }
            self.brokers.owed.extend(receipt);
            drop((payload, room));
            match feed.try_recv() {
                Ok(Chunk::Delivered(delivery)) if lines < ENOUGH => next = delivery,
                other => {
                    self.next = other.ok();
                    self.publish()?;
                    self.pulse.beat(oldest, lines, self.monitor.counts().rows - rows);
                    return Ok(());
                }
            }
        }
        self.next = Some(Chunk::Delivered(next));
        self.publish()?;
        self.pulse.beat(oldest, lines, self.monitor.counts().rows - rows);
        Ok(())
    }

    /// Judges the lines of a message, and notes their samples if they are to be kept.
    fn samples(
        &mut self,
        unit: Option<&str>,
        payload: &[u8],
        is_kept: bool,
    ) -> Result<u64, Failure> {
        let mut count = 0_u64;
        for line in payload.split(|byte| *byte == b'\n') {
            count += 1;
            if LONGEST_LINE < line.len() {
                self.rows.skip_long_line(LONGEST_LINE);
            } else if self.rows.read_of(unit, line).map_err(Failure::of_input)? {
                self.row()?;
                if let Some(state) = self.state.as_mut().filter(|_| is_kept) {
                    state.keep(self.rows.row());
                }
            }
            self.tell_faults();
            if count.is_multiple_of(ENOUGH) {
                self.publish()?;
                if self.stop.load(Ordering::Relaxed) {
                    break;
                }
            }
        }
        Ok(count)
    }

    /// Deals with answers that a broker has brought; they are acknowledged when they are kept.
    pub(super) fn replies(&mut self) -> Result<(), Failure> {
        let Some(questions) = &self.brokers.questions else { return Ok(()) };
        for (reply, said) in questions.replies() {
            let outcome = match said {
                Ok((id, confirmed)) => self.answer(&id, confirmed)?,
                Err(why) => Err(why),
            };
            if let Err(reason) = outcome {
                let what = What::AnswerRefused { reason };
                self.monitor.tell(Event { unit: None, time: None, what });
                self.publish()?;
            }
            reply.sign();
        }
        Ok(())
    }

    /// Signs for messages when their samples are on the disk; until then the broker keeps them.
    pub(super) fn sign(&mut self) {
        if self.brokers.owed.is_empty() {
            return;
        }
        if let Some(state) = &mut self.state
            && let Err(error) = state.secure(&self.monitor)
        {
            if !std::mem::replace(&mut self.cannot_save, true) {
                complain(&format!(
                    "fdiag: {error}; the broker keeps its samples until that is mended"
                ));
            }
            return;
        }
        self.brokers.owed.drain(..).for_each(Receipt::sign);
    }
}
