//! A message, field by field.

use super::{Bytes, Count, Definitions, Field, Kind, Number, TopicColumns};
use crate::{error::LogError, limit::Budget};

/// Messages may be in messages this deep.
const DEEPEST: usize = 16;

/// Why a message cannot be read.
#[derive(Debug)]
pub(in crate::format) enum NoMessage {
    /// It is not what its definition says.
    Unsound(String),
    /// There is too much of it all.
    Large(LogError),
}

impl NoMessage {
    /// The error of a file of a format.
    pub(in crate::format) fn of(self, file: &str, format: &'static str) -> LogError {
        match self {
            Self::Large(error) => error,
            Self::Unsound(found) => LogError::Damaged { file: file.to_owned(), format, found },
        }
    }

    /// The same, with the topic that the message belongs to.
    pub(in crate::format) fn in_topic(self, topic: &str) -> Self {
        match self {
            Self::Unsound(found) => Self::Unsound(format!("{found}, in topic `{topic}`")),
            large @ Self::Large(_) => large,
        }
    }
}

impl From<LogError> for NoMessage {
    fn from(error: LogError) -> Self {
        Self::Large(error)
    }
}

/// Where values go.
struct Walk<'a> {
    definitions: &'a Definitions,
    into: &'a mut TopicColumns,
    left: &'a mut Budget,
    /// Nanoseconds since 1970 at which the recording begins: stamps count from there, as its clock does.
    start: u64,
    path: String,
}

/// Puts the numbers of a message into the row that was begun.
///
/// Lists of numbers beside a list of as many texts called `name` (as in `JointState`) have these texts as indices;
/// lists of bytes are pictures and the like, and are passed over.
pub(in crate::format) fn decode(
    kind: &str,
    definitions: &Definitions,
    mut bytes: Bytes<'_>,
    start: u64,
    into: &mut TopicColumns,
    left: &mut Budget,
) -> Result<(), NoMessage> {
    let mut walk = Walk { definitions, into, left, start, path: String::new() };
    walk.message(kind, &mut bytes, 0)
}

fn too_short() -> NoMessage {
    NoMessage::Unsound("found a message that ends before its last field".to_owned())
}

impl Walk<'_> {
    fn message(
        &mut self,
        kind: &str,
        bytes: &mut Bytes<'_>,
        depth: usize,
    ) -> Result<(), NoMessage> {
        if depth > DEEPEST {
            let found = format!("found messages in messages more than {DEEPEST} deep");
            return Err(NoMessage::Unsound(found));
        }
        let definitions = self.definitions;
        let Some(fields) = definitions.get(kind) else {
            return Err(NoMessage::Unsound(format!("found no definition of `{kind}`")));
        };
        if fields.is_empty() {
            // ROS 2 puts one byte where there is nothing; and so every message has an end.
            bytes.take(1).ok_or_else(too_short)?;
        }
        let mut labels: Vec<String> = Vec::new();
        for field in fields {
            let before = self.path.len();
            if !self.path.is_empty() {
                self.path.push('.');
            }
            self.path.push_str(&field.name);
            self.field(field, bytes, depth, &mut labels)?;
            self.path.truncate(before);
        }
        Ok(())
    }

    fn field(
        &mut self,
        field: &Field,
        bytes: &mut Bytes<'_>,
        depth: usize,
        labels: &mut Vec<String>,
    ) -> Result<(), NoMessage> {
        let count = match field.count {
            Count::One => return self.one(&field.kind, bytes, depth, None),
            Count::Fixed(count) => count,
            Count::Sequence => bytes.length().ok_or_else(too_short)?,
        };
        if field.kind == Kind::Skipped {
            return bytes.take(count.min(bytes.left())).map(drop).ok_or_else(too_short);
        }
        // Nothing takes less than a byte.
        if count > bytes.left() {
            return Err(too_short());
        }
        if field.kind == Kind::Number(Number::Unsigned(1)) && field.count == Count::Sequence {
            return bytes.take(count).map(drop).ok_or_else(too_short);
        }
        let mut texts = Vec::new();
        let stem = self.path.len();
        for place in 0..count {
            let label = labels.get(place).filter(|_| labels.len() == count);
            let index = label.map_or_else(|| format!("[{place}]"), |label| format!("[{label}]"));
            self.path.push_str(&index);
            self.one(&field.kind, bytes, depth, Some(&mut texts))?;
            self.path.truncate(stem);
        }
        if field.name == "name" {
            *labels = texts;
        }
        Ok(())
    }

    fn one(
        &mut self,
        kind: &Kind,
        bytes: &mut Bytes<'_>,
        depth: usize,
        texts: Option<&mut Vec<String>>,
    ) -> Result<(), NoMessage> {
        match kind {
            Kind::Number(number) => {
                let value = bytes.number(*number).ok_or_else(too_short)?;
                Ok(self.into.put(&self.path, value, self.left)?)
            }
            Kind::Skipped => {
                bytes.take(bytes.left().min(1));
                Ok(())
            }
            Kind::Text => {
                let length = bytes.length().ok_or_else(too_short)?;
                let text = bytes.take(length).ok_or_else(too_short)?;
                let text = String::from_utf8_lossy(text.strip_suffix(b"\0").unwrap_or(text));
                match texts {
                    Some(texts) => texts.push(text.into_owned()),
                    #[cfg(any(feature = "mcap", feature = "rosbag"))]
                    None => self.into.note_frame(&self.path, &text),
                    #[cfg(not(any(feature = "mcap", feature = "rosbag")))]
                    None => {}
                }
                Ok(())
            }
            Kind::Message(name) if name == "builtin_interfaces/Time" => {
                let seconds = bytes.bits(4).ok_or_else(too_short)?;
                let nanos = bytes.bits(4).ok_or_else(too_short)?;
                let stamp = i128::from(seconds) * 1_000_000_000 + i128::from(nanos);
                let seconds = (stamp - i128::from(self.start)) as f64 * 1e-9;
                Ok(self.into.put(&self.path, seconds, self.left)?)
            }
            Kind::Message(name) => self.message(name, bytes, depth + 1),
        }
    }
}
