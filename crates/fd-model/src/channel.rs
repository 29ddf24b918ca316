//! Names and units of signals.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A named signal with its unit, such as `T_7 [K]`.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
pub struct Channel {
    /// Name, unique among the signals of its kind.
    pub name: String,
    /// Unit as written by the user; `"1"` for a pure number.
    pub unit: String,
}

impl Channel {
    /// A channel with a name and a unit.
    ///
    /// ```
    /// # use fd_model::Channel;
    /// assert_eq!(Channel::new("T_7", "K").to_string(), "T_7 [K]");
    /// ```
    pub fn new(name: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { name: name.into(), unit: unit.into() }
    }

    /// Channels `prefix1`, `prefix2`, … that are pure numbers.
    ///
    /// ```
    /// # use fd_model::Channel;
    /// assert_eq!(Channel::numbered("u", 2)[1].name, "u2");
    /// ```
    #[must_use]
    pub fn numbered(prefix: &str, count: usize) -> Vec<Self> {
        (1..=count).map(|i| Self::new(format!("{prefix}{i}"), "1")).collect()
    }
}

impl fmt::Display for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} [{}]", self.name, self.unit)
    }
}
