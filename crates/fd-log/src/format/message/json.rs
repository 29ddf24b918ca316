//! Messages in JSON: objects within objects are `pose.x`, lists `q[0]`, truth values 0 and 1.

use serde_json::{Map, Value};

use super::{NoMessage, TopicColumns};
use crate::limit::Budget;

/// Puts the numbers of a message into the row that was begun. Texts are passed over, but for those called `name`, which
/// are the indices of equally long lists beside them.
pub(in crate::format) fn decode(
    data: &[u8],
    start: u64,
    into: &mut TopicColumns,
    left: &mut Budget,
) -> Result<(), NoMessage> {
    let message: Value = serde_json::from_slice(data)
        .map_err(|error| NoMessage::Unsound(format!("found a message that is no JSON: {error}")))?;
    let mut walk = Walk { start, into, left, path: String::new() };
    match &message {
        Value::Object(fields) => walk.object(fields),
        other => {
            walk.path.push_str("data");
            walk.value(other, &[])
        }
    }
}

struct Walk<'a> {
    start: u64,
    into: &'a mut TopicColumns,
    left: &'a mut Budget,
    path: String,
}

impl Walk<'_> {
    fn object(&mut self, fields: &Map<String, Value>) -> Result<(), NoMessage> {
        if let Some(stamp) = stamp(fields) {
            let seconds = (stamp - i128::from(self.start)) as f64 * 1e-9;
            return Ok(self.into.put(&self.path, seconds, self.left)?);
        }
        let labels = fields.get("name").and_then(Value::as_array);
        let labels: Vec<&str> =
            labels.map_or(Vec::new(), |names| names.iter().filter_map(Value::as_str).collect());
        for (key, value) in fields {
            let before = self.path.len();
            if before > 0 {
                self.path.push('.');
            }
            self.path.push_str(key);
            self.value(value, &labels)?;
            self.path.truncate(before);
        }
        Ok(())
    }

    fn value(&mut self, value: &Value, labels: &[&str]) -> Result<(), NoMessage> {
        let number = match value {
            Value::Null => f64::NAN,
            Value::Bool(is_on) => f64::from(u8::from(*is_on)),
            Value::Number(number) => number.as_f64().unwrap_or(f64::NAN),
            Value::String(text) => {
                self.into.note_frame(&self.path, text);
                return Ok(());
            }
            Value::Object(fields) => return self.object(fields),
            Value::Array(list) => {
                for (place, value) in list.iter().enumerate() {
                    let before = self.path.len();
                    let label = labels.get(place).filter(|_| labels.len() == list.len());
                    self.path += &label.map_or_else(|| format!("[{place}]"), |l| format!("[{l}]"));
                    self.value(value, &[])?;
                    self.path.truncate(before);
                }
                return Ok(());
            }
        };
        Ok(self.into.put(&self.path, number, self.left)?)
    }
}

/// Nanoseconds since 1970 of a time as ROS and Foxglove write it: seconds and nanoseconds, and nothing else.
fn stamp(fields: &Map<String, Value>) -> Option<i128> {
    let of = |names: [&str; 2]| names.iter().find_map(|name| fields.get(*name)?.as_i64());
    let (seconds, nanos) = (of(["sec", "secs"])?, of(["nsec", "nanosec"])?);
    (fields.len() == 2).then(|| i128::from(seconds) * 1_000_000_000 + i128::from(nanos))
}
