//! Progress on standard error, only when somebody is looking.

use std::{
    io::IsTerminal,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering::Relaxed},
        mpsc::{RecvTimeoutError, Sender, channel},
    },
    thread::JoinHandle,
    time::Duration,
};

use fd_lab::Watcher;
use fdiag::gap::diagnose::{Monitor, Stage};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// After this long, a waiting user wants to know what for.
const PATIENCE: Duration = Duration::from_secs(2);
/// Time between two drawings.
const TICK: Duration = Duration::from_millis(200);

/// A bar over work of many alike pieces; invisible when standard error is not a terminal.
pub(crate) struct Bar(ProgressBar);

impl Bar {
    pub(crate) fn new(what: &'static str) -> Self {
        let target = if std::io::stderr().is_terminal() {
            ProgressDrawTarget::stderr()
        } else {
            ProgressDrawTarget::hidden()
        };
        let bar = ProgressBar::with_draw_target(Some(1), target);
        let style = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len}, {eta} left");
        if let Ok(style) = style {
            bar.set_style(style);
        }
        bar.set_message(what);
        bar.enable_steady_tick(TICK);
        Self(bar)
    }

    pub(crate) fn finish(self) {
        self.0.finish_and_clear();
    }
}

impl Watcher for Bar {
    fn begin(&self, pieces: u64, done: u64) {
        self.0.set_length(pieces);
        self.0.set_position(done);
        // What was done before says nothing about the time that is left.
        self.0.reset_eta();
    }

    fn advance(&self) {
        self.0.inc(1);
    }
}

/// Progress of a diagnosis, one stage after another; shown once it takes long.
pub(crate) struct Stages {
    bar: ProgressBar,
    /// Dropped at the end, which the thread that shows the bar hears.
    ended: Option<Sender<()>>,
    shown: Option<JoinHandle<()>>,
    /// Whether nobody wants to wait any longer.
    is_stopped: Arc<AtomicBool>,
}

impl Stages {
    pub(crate) fn new() -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden());
        if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {elapsed}") {
            bar.set_style(style);
        }
        let (ended, end) = channel();
        let late = bar.clone();
        let shown = std::io::stderr().is_terminal().then(|| {
            std::thread::spawn(move || {
                if end.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
                    late.set_draw_target(ProgressDrawTarget::stderr());
                    // Also within a long piece somebody sees that it lives.
                    late.enable_steady_tick(TICK);
                }
            })
        });
        Self { bar, ended: Some(ended), shown, is_stopped: Arc::default() }
    }

    /// The same, stopped by a flag.
    pub(crate) fn stopped_by(self, is_stopped: Arc<AtomicBool>) -> Self {
        let mut stages = self;
        stages.is_stopped = is_stopped;
        stages
    }

    pub(crate) fn finish(mut self) {
        self.ended = None;
        if let Some(shown) = self.shown.take() {
            // It only waits; when it has panicked there is nothing to clear.
            let _ = shown.join();
        }
        self.bar.finish_and_clear();
    }
}

impl Monitor for Stages {
    fn begin(&self, stage: Stage, pieces: usize) {
        self.bar.set_length(pieces as u64);
        self.bar.set_position(0);
        self.bar.set_message(match stage {
            Stage::StandIn => "linearising the simulator",
            Stage::Screen => "trying effects",
            Stage::Fit => "fitting",
            Stage::Pairs => "trying pairs",
            Stage::Judge => "judging",
            Stage::Locate => "locating",
            Stage::Ceiling => "learning black boxes",
            Stage::Experiment => "trying experiments",
            Stage::Calibrate => "diagnosing simulated logs",
        });
    }

    fn advance(&self) {
        self.bar.inc(1);
    }

    fn is_stopped(&self) -> bool {
        self.is_stopped.load(Relaxed)
    }

    fn plan(&self, text: &str) {
        self.bar.suspend(|| eprintln!("{text}"));
    }
}
