//! Messages of robots: what their definitions say, and their bytes as columns of numbers.

mod bytes;
mod columns;
mod decode;
#[cfg(any(feature = "mcap", feature = "rosbag"))]
pub(super) mod definition;
#[cfg(feature = "mcap")]
pub(super) mod json;
#[cfg(feature = "mcap")]
pub(super) mod protobuf;
#[cfg(any(feature = "mcap", feature = "rosbag"))]
mod topics;

use std::collections::BTreeMap;

#[cfg(any(feature = "mcap", feature = "rosbag"))]
pub(super) use self::topics::Topics;
pub(super) use self::{
    bytes::Bytes,
    columns::TopicColumns,
    decode::{NoMessage, decode},
};

/// Kinds of messages by name, and their fields in order.
pub(super) type Definitions = BTreeMap<String, Vec<Field>>;

/// A field of a message.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Field {
    pub name: String,
    pub kind: Kind,
    pub count: Count,
}

/// What a field holds.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Kind {
    Number(Number),
    /// Text with a length before it.
    #[cfg_attr(not(any(feature = "mcap", feature = "rosbag")), allow(dead_code))]
    Text,
    /// A byte that is nobody's number; those at the end may be left out.
    #[cfg_attr(not(feature = "ulog"), allow(dead_code))]
    Skipped,
    /// A message of this name.
    Message(String),
}

/// How many of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Count {
    One,
    Fixed(usize),
    /// As many as a number before them says.
    #[cfg_attr(not(any(feature = "mcap", feature = "rosbag")), allow(dead_code))]
    Sequence,
}

/// How a number is stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Number {
    Unsigned(usize),
    Signed(usize),
    Float(usize),
}

impl Number {
    pub(super) fn bytes(self) -> usize {
        let (Self::Unsigned(bytes) | Self::Signed(bytes) | Self::Float(bytes)) = self;
        bytes
    }

    /// The names of ROS, and with `_t` behind them and `double` those of C.
    pub(super) fn parse(name: &str) -> Option<Self> {
        Some(match name.strip_suffix("_t").unwrap_or(name) {
            "bool" | "byte" | "char" | "uint8" => Self::Unsigned(1),
            "uint16" => Self::Unsigned(2),
            "uint32" => Self::Unsigned(4),
            "uint64" => Self::Unsigned(8),
            "int8" => Self::Signed(1),
            "int16" => Self::Signed(2),
            "int32" => Self::Signed(4),
            "int64" => Self::Signed(8),
            "float" | "float32" => Self::Float(4),
            "double" | "float64" => Self::Float(8),
            _ => return None,
        })
    }
}
