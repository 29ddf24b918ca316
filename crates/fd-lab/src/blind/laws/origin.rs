//! Where a law comes from.

use serde::{Deserialize, Serialize};

/// Where a law comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Origin {
    /// The library has such a law.
    Matched,
    /// The library has the label, but not this law.
    Mismatch,
    /// The library has no such label.
    Withheld,
    /// A parameter walks.
    Wander,
    /// It acts on a signal inside the model.
    Inside,
}
