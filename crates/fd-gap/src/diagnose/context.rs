//! The context that every step can use.

use super::{candidates::Candidates, case::Case, monitor::Monitor, settings::Settings};

/// What every step may look at, and none may change.
#[derive(Clone, Copy)]
pub(super) struct Context<'a> {
    /// The case as it is diagnosed: with the controller on logged outputs, if it did see these.
    pub case: Case<'a>,
    pub candidates: &'a Candidates,
    pub settings: &'a Settings,
    pub monitor: &'a dyn Monitor,
}
