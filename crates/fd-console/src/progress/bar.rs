//! Work of many alike pieces: how far it is, what it will cost, when it is enough.

use std::{
    sync::{
        Mutex, OnceLock, PoisonError,
        atomic::{AtomicU64, Ordering::Relaxed},
    },
    time::{Duration, Instant},
};

use fdiag::{Watcher, model::duration};
use indicatif::{ProgressBar, ProgressState, ProgressStyle};

use super::{TICK, target};
use crate::{
    failure::Failure,
    patience::{PatienceArgs, Plan},
    say::remark,
};

/// What is shown before work begins: whatever there is to read or to learn from first.
const PREPARING: &str = "preparing";
/// Work is extrapolated from pieces that took at least this long together.
const WATCHED: Duration = Duration::from_secs(1);
/// What the bar counts in each piece.
const GRAIN: u64 = 1000;
/// Steps of a piece need not take equally long: the first may take nearly all of its time. Once this part of the steps of
/// all pieces at work is done, what is extrapolated is too long by its inverse at most.
const PART: f64 = 0.5;

/// A bar over work of many alike pieces; invisible when standard error is not a terminal.
pub struct Bar {
    shown: ProgressBar,
    what: &'static str,
    patience: PatienceArgs,
    /// Memory that a piece needs until the end, in bytes.
    bytes: f64,
    begun: Instant,
    /// What this run works on, since it has begun.
    work: Mutex<Option<Work>>,
    finished: AtomicU64,
    /// Steps of pieces, finished or not, in parts of [`GRAIN`].
    steps: AtomicU64,
    /// Why it was not gone on with.
    refused: OnceLock<String>,
    /// Whether the cost was looked at, and before that whether it was guessed.
    is_planned: OnceLock<()>,
    is_guessed: OnceLock<()>,
}

/// Work that has begun.
#[derive(Clone, Copy)]
struct Work {
    begun: Instant,
    /// Pieces that are to be done, and those that an earlier run has done.
    pieces: u64,
    before: u64,
}

impl Bar {
    /// A bar over pieces that are called `what`.
    #[must_use]
    pub fn new(what: &'static str) -> Self {
        let bar = ProgressBar::with_draw_target(Some(1), target());
        let style = ProgressStyle::with_template("{msg} {wide_bar} {pieces}{time_left}");
        if let Ok(style) = style {
            let time_left = |state: &ProgressState, out: &mut dyn std::fmt::Write| {
                // A writer of text does not fail.
                let _ = out.write_str(&left(state.pos(), state.eta()));
            };
            let pieces = |state: &ProgressState, out: &mut dyn std::fmt::Write| {
                let all = state.len().unwrap_or_default() / GRAIN;
                if 0 < all {
                    let _ = write!(out, "{}/{all}", state.pos() / GRAIN);
                }
            };
            bar.set_style(style.with_key("time_left", time_left).with_key("pieces", pieces));
        }
        bar.set_message(PREPARING);
        bar.enable_steady_tick(TICK);
        Self {
            shown: bar,
            what,
            patience: PatienceArgs { yes: true, ..PatienceArgs::default() },
            bytes: 0.0,
            begun: Instant::now(),
            work: Mutex::default(),
            finished: AtomicU64::new(0),
            steps: AtomicU64::new(0),
            refused: OnceLock::new(),
            is_planned: OnceLock::new(),
            is_guessed: OnceLock::new(),
        }
    }

    /// The same, for a user who waits only so long; a piece needs so many bytes until the end.
    #[must_use]
    pub fn within(self, patience: &PatienceArgs, bytes: f64) -> Self {
        Self { patience: patience.clone(), bytes, ..self }
    }

    /// The end. What was too large to be gone on with is a failure.
    ///
    /// # Errors
    ///
    /// What was refused because of its size.
    pub fn finish(self) -> Result<(), Failure> {
        self.shown.finish_and_clear();
        self.refused.into_inner().map_or(Ok(()), |reason| Err(Failure::Analysis(reason)))
    }

    /// Why work that keeps what it has finished in `kept` was not done to its end.
    pub fn stopped(self, kept: &std::path::Path) -> Failure {
        let before = self.work().map_or(0, |work| work.before);
        let done = before + self.finished.load(Relaxed);
        let (what, kept) = (self.what, kept.display());
        self.shown.finish_and_clear();
        let limit = self.patience.time_limit.map_or(0.0, |limit| limit.as_secs_f64());
        let why = self.refused.into_inner();
        let why =
            why.unwrap_or_else(|| format!("stopped by the time limit of {}", duration(limit)));
        Failure::Analysis(format!("{why} ({done} {what} are finished and kept in {kept})"))
    }

    fn work(&self) -> Option<Work> {
        *self.work.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Shows how far it is.
    fn show(&self) -> Option<(Work, u64, f64)> {
        let work = self.work()?;
        let finished = self.finished.load(Relaxed);
        let ticks = (finished * GRAIN).max(self.steps.load(Relaxed));
        self.shown.set_position((work.before * GRAIN).saturating_add(ticks));
        Some((work, finished, ticks as f64 / GRAIN as f64))
    }

    /// Says what is to come, once there is something to go by: half of the first pieces, and then a round of all threads.
    fn plan(&self, work: Work, finished: u64, done: f64) {
        let elapsed = work.begun.elapsed();
        if elapsed < WATCHED || work.pieces <= finished {
            return;
        }
        let at_work = (rayon::current_num_threads() as u64).min(work.pieces);
        let is_sure = at_work <= finished;
        if done < PART * at_work as f64 {
            return;
        }
        let looked = if is_sure { &self.is_planned } else { &self.is_guessed };
        if looked.set(()).is_err() {
            return;
        }
        let left = work.pieces - finished;
        let seconds = elapsed.as_secs_f64() / done * (work.pieces as f64 - done);
        let bytes = self.bytes * work.pieces as f64;
        let what = self.what;
        match self.patience.plan(seconds, bytes) {
            Plan::Short => {}
            Plan::Told(cost) if is_sure => {
                self.shown.suspend(|| remark(&format!("{left} more {what}: {cost}")));
            }
            // What is doubtful is told, and looked at again.
            Plan::Told(_) => self.guess(left, seconds, bytes),
            Plan::Refused(_)
                if !is_sure
                    && matches!(
                        self.patience.plan(PART * seconds, bytes),
                        Plan::Short | Plan::Told(_)
                    ) =>
            {
                self.guess(left, seconds, bytes);
            }
            Plan::Refused(cost) => {
                let reason = format!("{left} more {what}: {cost}; go on with --yes");
                // Looked at once.
                let _ = self.refused.set(reason);
            }
        }
    }

    fn guess(&self, left: u64, seconds: f64, bytes: f64) {
        let cost = PatienceArgs { yes: true, ..self.patience.clone() }.plan(seconds, bytes);
        if let Plan::Told(cost) = cost {
            let what = self.what;
            self.shown.suspend(|| remark(&format!("{left} {what}: {cost}, as the first ones go")));
        }
    }
}

impl Watcher for Bar {
    fn begin(&self, pieces: u64, done: u64) {
        self.shown.set_message(self.what);
        self.shown.set_length(pieces.saturating_mul(GRAIN));
        self.shown.set_position(done.saturating_mul(GRAIN));
        // What was done before says nothing about the time that is left.
        self.shown.reset_eta();
        let pieces = pieces.saturating_sub(done);
        let work = Work { begun: Instant::now(), pieces, before: done };
        *self.work.lock().unwrap_or_else(PoisonError::into_inner) = Some(work);
    }

    fn advance(&self) {
        self.finished.fetch_add(1, Relaxed);
        if let Some((work, finished, done)) = self.show() {
            self.plan(work, finished, done);
        }
    }

    fn step(&self, step: usize, steps: usize) {
        let until = |step: usize| GRAIN * step as u64 / steps.max(1) as u64;
        self.steps.fetch_add(until(step) - until(step.saturating_sub(1)), Relaxed);
        if let Some((work, finished, done)) = self.show().filter(|(.., done)| 0.0 < *done) {
            self.plan(work, finished, done);
        }
    }

    fn is_stopped(&self) -> bool {
        let is_over = |limit: Duration| limit <= self.begun.elapsed();
        self.refused.get().is_some() || self.patience.time_limit.is_some_and(is_over)
    }
}

/// The time that is left, once a piece is done.
fn left(finished: u64, eta: Duration) -> String {
    match eta.as_secs() {
        _ if finished < GRAIN => String::new(),
        0 => ", less than 1 s left".to_owned(),
        // Minutes of what takes hours are no news.
        seconds => format!(", {} left", duration(seconds as f64)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nobody_is_told_that_nothing_is_left() {
        let texts = [(0, 0), (3, 0), (3, 7), (3, 600)]
            .map(|(pieces, seconds)| left(GRAIN * pieces, Duration::from_secs(seconds)));
        assert_eq!(texts, ["", ", less than 1 s left", ", 7 s left", ", 10 min left"]);
    }

    #[test]
    fn what_is_too_large_is_stopped_after_the_first_round() {
        let patience = PatienceArgs::default();
        let bar = Bar::new("engines").within(&patience, 0.0);
        bar.begin(1_000_000, 0);
        assert!(!bar.is_stopped());
        // One thread's worth of a round, that took longer than what is extrapolated from.
        std::thread::sleep(WATCHED);
        (0..rayon::current_num_threads()).for_each(|_| bar.advance());
        assert!(bar.is_stopped());
        let failure = bar.finish().unwrap_err().to_string();
        assert!(failure.contains("more engines: about") && failure.contains("--yes"), "{failure}");
    }

    #[test]
    fn half_of_the_first_pieces_says_what_is_far_too_large() {
        let patience = PatienceArgs::default();
        let threads = rayon::current_num_threads() as u64;
        // Two seconds a piece and thread: hours, or a quarter of one.
        for (pieces, is_too_large) in [(10_000, true), (400, false)] {
            let bar = Bar::new("engines").within(&patience, 0.0);
            bar.begin(pieces * threads, 0);
            std::thread::sleep(WATCHED);
            (0..threads).for_each(|_| bar.step(1, 2));
            assert_eq!(bar.is_stopped(), is_too_large, "{pieces}");
            assert_eq!(bar.finish().is_err(), is_too_large, "{pieces}");
        }
    }

    /// The first of a hundred steps takes a second, all others nothing: 95 minutes were said of what took half of one.
    #[test]
    fn a_slow_first_step_says_nothing() {
        let patience = PatienceArgs::default();
        let bar = Bar::new("engines").within(&patience, 0.0);
        bar.begin(60, 0);
        std::thread::sleep(WATCHED);
        bar.step(1, 100);
        assert!(bar.is_guessed.get().is_none() && !bar.is_stopped());
        (0..rayon::current_num_threads()).for_each(|_| bar.advance());
        assert!(bar.is_planned.get().is_some() && !bar.is_stopped());
    }
}
