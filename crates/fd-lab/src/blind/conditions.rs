//! Under which conditions the logs of a case were taken.

use serde::{Deserialize, Serialize};

use super::{controller::Controller, logger::Logger, misreading::Misreading};

/// Under which conditions the logs of a case were taken; by default from rest, in separate runs, in
/// the loop of the model if it has one, with a perfect logger.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Conditions {
    /// The controller that is not in the model.
    pub controller: Option<Controller>,
    /// Samples that the plant had run before a log begins.
    pub before: usize,
    /// Whether the held-out log goes on where the fitted one ends.
    pub is_cut: bool,
    /// What the logger makes of the values.
    pub logger: Option<Logger>,
    /// What is read wrongly.
    pub misreading: Option<Misreading>,
}

impl Conditions {
    /// Whether there is nothing special about them.
    #[must_use]
    pub fn is_plain(&self) -> bool {
        *self == Self::default()
    }

    /// Samples of the plant per sample of the log.
    pub(super) fn stretch(&self) -> usize {
        match &self.misreading {
            Some(Misreading::Time { factor }) => *factor,
            _ => 1,
        }
    }
}
