//! What the loop owes to brokers: receipts for samples, and news of the journal.

use std::time::Duration;

use fd_watch::Message;

use super::mqtt::{Outlet, Questions, Receipt};

/// Longest that an end waits for a broker to hear the last alarms.
const FAREWELL: Duration = Duration::from_secs(2);

/// What the loop knows of brokers.
#[derive(Default)]
pub(super) struct Brokers {
    pub outlet: Option<Outlet>,
    /// Questions to whoever listens.
    pub questions: Option<Questions>,
    /// For messages whose samples are not yet on the disk.
    pub owed: Vec<Receipt>,
}

impl Brokers {
    /// The journal has grown.
    pub(super) fn promised(&self, bytes: u64) {
        if let Some(outlet) = &self.outlet {
            outlet.promised(bytes);
        }
    }

    /// Something was said.
    pub(super) fn hear(&self, messages: &[Message]) {
        if let Some(questions) = &self.questions {
            questions.hear(messages);
        }
    }

    /// Answers have been kept.
    pub(super) fn settle(&self) {
        if let Some(questions) = &self.questions {
            questions.settle();
        }
    }

    /// Bytes of the journal that the broker has not heard.
    pub(super) fn behind(&self) -> Option<u64> {
        self.outlet.as_ref().map(Outlet::behind)
    }

    /// Gives the broker time to hear the last alarms.
    pub(super) fn finish(&self) {
        if let Some(outlet) = &self.outlet {
            outlet.finish(FAREWELL);
        }
    }
}
