//! Names and units of signals.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{circle::Circle, unit::turn};

/// A named signal with its unit, such as `T_7 [K]`.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
pub struct Channel {
    /// Name, unique among the signals of its kind.
    pub name: String,
    /// Unit as written by the user; `"1"` for a pure number.
    pub unit: String,
    /// Whether it is an angle that begins anew after a turn.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub wraps: bool,
}

impl Channel {
    /// A channel with a name and a unit.
    ///
    /// ```
    /// # use fd_model::Channel;
    /// assert_eq!(Channel::new("T_7", "K").to_string(), "T_7 [K]");
    /// ```
    pub fn new(name: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { name: name.into(), unit: unit.into(), wraps: false }
    }

    /// The same, as an angle that begins anew after a turn if it `wraps`.
    ///
    /// ```
    /// # use fd_model::Channel;
    /// let heading = Channel::new("heading", "deg").wrapping(true);
    /// assert_eq!(heading.circle().turn(), Some(360.0));
    /// assert!(Channel::new("heading", "deg").circle().is_line());
    /// ```
    #[must_use]
    pub fn wrapping(self, wraps: bool) -> Self {
        Self { wraps, ..self }
    }

    /// Where its values live; what wraps in a unit that is none of angles is on a line.
    #[must_use]
    pub fn circle(&self) -> Circle {
        self.wraps.then(|| turn(&self.unit)).flatten().map_or(Circle::LINE, Circle::new)
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
