//! What is left out when the user stops a study.

use std::cell::RefCell;

use fd_gap::diagnose::{Diagnosis, Monitor};

/// Asks before each part of a study whether anybody still waits for it.
pub(super) struct Pause<'a> {
    monitor: &'a dyn Monitor,
    left_out: RefCell<Vec<&'static str>>,
}

impl<'a> Pause<'a> {
    pub(super) fn of(monitor: &'a dyn Monitor) -> Self {
        Self { monitor, left_out: RefCell::default() }
    }

    /// Whether a part is to be done; what is not is noted.
    pub(super) fn goes_on(&self, part: &'static str) -> bool {
        let is_stopped = self.monitor.is_stopped();
        if is_stopped {
            self.left_out.borrow_mut().push(part);
        }
        !is_stopped
    }

    /// The same of a part that has been done: one that was cut short is worth nothing, and is left out.
    pub(super) fn came_to_its_end(&self, part: &'static str) -> bool {
        self.goes_on(part)
    }

    /// The time limit, in seconds, that ended it, if one did.
    pub(super) fn time_limit(&self) -> Option<f64> {
        self.monitor.time_limit()
    }

    /// What was left out, with what the diagnosis did not come to.
    pub(super) fn left_out(self, diagnosis: &Diagnosis) -> Vec<String> {
        let untried = diagnosis.is_stopped.then_some("effects and pairs that had not been tried");
        untried.into_iter().chain(self.left_out.into_inner()).map(str::to_owned).collect()
    }
}
