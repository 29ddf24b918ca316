//! Progress of a diagnosis, one stage after another.

use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering::Relaxed},
        mpsc::{RecvTimeoutError, Sender, channel},
    },
    thread::JoinHandle,
    time::{Duration, Instant},
};

use fdiag::gap::diagnose::{Monitor, Stage};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::TICK;
use crate::say::{is_watched, remark};

/// After this long, a waiting user wants to know what for.
const PATIENCE: Duration = Duration::from_secs(2);

/// Progress of a diagnosis; shown once it takes long.
pub struct Stages {
    bar: ProgressBar,
    /// Dropped at the end, which the thread that shows the bar hears.
    ended: Option<Sender<()>>,
    shown: Option<JoinHandle<()>>,
    /// Whether nobody wants to wait any longer.
    is_stopped: Arc<AtomicBool>,
    begun: Instant,
    /// The longest that anybody waits.
    limit: Option<Duration>,
}

impl Default for Stages {
    fn default() -> Self {
        Self::new()
    }
}

impl Stages {
    /// Shown after two seconds, where somebody looks.
    #[must_use]
    pub fn new() -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden());
        if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {elapsed}") {
            bar.set_style(style);
        }
        let (ended, end) = channel();
        let late = bar.clone();
        let shown = is_watched().then(|| {
            std::thread::spawn(move || {
                if end.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
                    late.set_draw_target(ProgressDrawTarget::stderr());
                    // Also within a long piece somebody sees that it lives.
                    late.enable_steady_tick(TICK);
                }
            })
        });
        let begun = Instant::now();
        Self { bar, ended: Some(ended), shown, is_stopped: Arc::default(), begun, limit: None }
    }

    /// The same, stopped by a flag or after so long.
    #[must_use]
    pub fn stopped_by(self, is_stopped: Arc<AtomicBool>, limit: Option<Duration>) -> Self {
        let mut stages = self;
        (stages.is_stopped, stages.limit) = (is_stopped, limit);
        stages
    }

    /// The end of what is shown.
    pub fn finish(mut self) {
        self.ended = None;
        if let Some(shown) = self.shown.take() {
            // It only waits; when it has panicked there is nothing to clear.
            let _ = shown.join();
        }
        self.bar.finish_and_clear();
    }

    fn is_late(&self) -> bool {
        self.limit.is_some_and(|limit| limit <= self.begun.elapsed())
    }
}

impl Monitor for Stages {
    fn begin(&self, stage: Stage, pieces: usize) {
        self.bar.set_length(pieces as u64);
        self.bar.set_position(0);
        self.bar.set_message(stage.words());
    }

    fn advance(&self) {
        self.bar.inc(1);
    }

    fn is_stopped(&self) -> bool {
        self.is_stopped.load(Relaxed) || self.is_late()
    }

    fn time_limit(&self) -> Option<f64> {
        let is_asked = self.is_stopped.load(Relaxed);
        self.limit.filter(|_| self.is_late() && !is_asked).map(|limit| limit.as_secs_f64())
    }

    fn plan(&self, text: &str) {
        self.bar.suspend(|| remark(text));
    }
}
