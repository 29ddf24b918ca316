//! Work of many alike pieces: how far it is, what it will cost, when it is enough.

use std::{
    sync::{
        Mutex, OnceLock, PoisonError,
        atomic::{AtomicU64, Ordering::Relaxed},
    },
    time::{Duration, Instant},
};

use fd_lab::Watcher;
use fdiag::model::duration;
use indicatif::{ProgressBar, ProgressState, ProgressStyle};

use super::{
    super::{
        failure::Failure,
        patience::{PatienceArgs, Plan},
        say::remark,
    },
    TICK, target,
};

/// Work is extrapolated from pieces that took at least this long together.
const WATCHED: Duration = Duration::from_secs(1);

/// A bar over work of many alike pieces; invisible when standard error is not a terminal.
pub(crate) struct Bar {
    shown: ProgressBar,
    what: &'static str,
    patience: PatienceArgs,
    /// Memory that a piece needs until the end, in bytes.
    bytes: f64,
    begun: Instant,
    /// When this run began to work, and on how many pieces.
    work: Mutex<Option<(Instant, u64)>>,
    finished: AtomicU64,
    /// Why it was not gone on with.
    refused: OnceLock<String>,
    /// Whether the cost was looked at.
    is_planned: OnceLock<()>,
}

impl Bar {
    pub(crate) fn new(what: &'static str) -> Self {
        let bar = ProgressBar::with_draw_target(Some(1), target());
        let style = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len}{time_left}");
        if let Ok(style) = style {
            bar.set_style(style.with_key(
                "time_left",
                |state: &ProgressState, out: &mut dyn std::fmt::Write| {
                    // A writer of text does not fail.
                    let _ = out.write_str(&left(state.pos(), state.eta()));
                },
            ));
        }
        bar.set_message(what);
        bar.enable_steady_tick(TICK);
        Self {
            shown: bar,
            what,
            patience: PatienceArgs { yes: true, ..PatienceArgs::default() },
            bytes: 0.0,
            begun: Instant::now(),
            work: Mutex::default(),
            finished: AtomicU64::new(0),
            refused: OnceLock::new(),
            is_planned: OnceLock::new(),
        }
    }

    /// The same, for a user who waits only so long; a piece needs so many bytes until the end.
    pub(crate) fn within(self, patience: &PatienceArgs, bytes: f64) -> Self {
        Self { patience: patience.clone(), bytes, ..self }
    }

    /// The end. What was too large to be gone on with is a failure.
    pub(crate) fn finish(self) -> Result<(), Failure> {
        self.shown.finish_and_clear();
        self.refused.into_inner().map_or(Ok(()), |reason| Err(Failure::Analysis(reason)))
    }

    /// Why work that keeps what it has finished in `kept` was not done to its end.
    pub(crate) fn stopped(self, kept: &std::path::Path) -> Failure {
        let (done, what, kept) = (self.shown.position(), self.what, kept.display());
        self.shown.finish_and_clear();
        let limit = self.patience.time_limit.map_or(0.0, |limit| limit.as_secs_f64());
        let why = self.refused.into_inner();
        let why =
            why.unwrap_or_else(|| format!("stopped by the time limit of {}", duration(limit)));
        Failure::Analysis(format!("{why} ({done} {what} are finished and kept in {kept})"))
    }

    /// Says what is to come, once there is something to go by: a round of all threads.
    fn plan(&self, finished: u64) {
        let work = *self.work.lock().unwrap_or_else(PoisonError::into_inner);
        let Some((begun, pieces)) = work else { return };
        let elapsed = begun.elapsed();
        let is_early = finished < rayon::current_num_threads() as u64 || elapsed < WATCHED;
        if is_early || pieces <= finished || self.is_planned.set(()).is_err() {
            return;
        }
        let left = pieces - finished;
        let seconds = elapsed.as_secs_f64() / finished as f64 * left as f64;
        match self.patience.plan(seconds, self.bytes * pieces as f64) {
            Plan::Short => {}
            Plan::Told(cost) => {
                self.shown.suspend(|| remark(&format!("{left} more {}: {cost}", self.what)));
            }
            Plan::Refused(cost) => {
                let reason = format!("{left} more {}: {cost}; go on with --yes", self.what);
                // Looked at once.
                let _ = self.refused.set(reason);
            }
        }
    }
}

impl Watcher for Bar {
    fn begin(&self, pieces: u64, done: u64) {
        self.shown.set_length(pieces);
        self.shown.set_position(done);
        // What was done before says nothing about the time that is left.
        self.shown.reset_eta();
        let work = (Instant::now(), pieces.saturating_sub(done));
        *self.work.lock().unwrap_or_else(PoisonError::into_inner) = Some(work);
    }

    fn advance(&self) {
        self.shown.inc(1);
        self.plan(1 + self.finished.fetch_add(1, Relaxed));
    }

    fn is_stopped(&self) -> bool {
        let is_over = |limit: Duration| limit <= self.begun.elapsed();
        self.refused.get().is_some() || self.patience.time_limit.is_some_and(is_over)
    }
}

/// The time that is left, as far as it is known.
fn left(finished: u64, eta: Duration) -> String {
    match eta.as_secs() {
        _ if finished == 0 => String::new(),
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
            .map(|(finished, seconds)| left(finished, Duration::from_secs(seconds)));
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
}
