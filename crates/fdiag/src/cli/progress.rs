//! Progress on standard error, only when somebody is looking.

use std::{
    io::IsTerminal,
    time::{Duration, Instant},
};

use fdiag::gap::{Monitor, Stage};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Time after which somebody who waits wants to know for what.
const PATIENCE: Duration = Duration::from_secs(2);

/// A bar over `length` steps; invisible when standard error is not a terminal.
pub(crate) fn bar(length: u64, what: &'static str) -> ProgressBar {
    let target = if std::io::stderr().is_terminal() {
        ProgressDrawTarget::stderr()
    } else {
        ProgressDrawTarget::hidden()
    };
    let bar = ProgressBar::with_draw_target(Some(length), target);
    if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len}, {eta} left") {
        bar.set_style(style);
    }
    bar.set_message(what);
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// Progress of a diagnosis, one stage after another; shown once it takes long.
pub(crate) struct Stages {
    bar: ProgressBar,
    begun: Instant,
}

impl Stages {
    pub(crate) fn new() -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden());
        if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len}") {
            bar.set_style(style);
        }
        Self { bar, begun: Instant::now() }
    }

    pub(crate) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl Monitor for Stages {
    fn begin(&self, stage: Stage, pieces: usize) {
        self.bar.set_length(pieces as u64);
        self.bar.set_position(0);
        self.bar.set_message(match stage {
            Stage::Screen => "trying effects",
            Stage::Fit => "fitting",
            Stage::Pairs => "trying pairs",
            Stage::Judge => "judging",
        });
    }

    fn advance(&self) {
        self.bar.inc(1);
        let is_awaited = self.bar.is_hidden() && PATIENCE < self.begun.elapsed();
        if is_awaited && std::io::stderr().is_terminal() {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
        }
    }
}
