//! A part of a snapshot.

use serde::{Deserialize, Serialize};

/// Numbers under a name, as their bits.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Field {
    pub name: String,
    pub bits: Vec<u64>,
}
