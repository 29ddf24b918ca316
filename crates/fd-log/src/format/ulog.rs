//! Flight logs of PX4, <https://docs.px4.io/main/en/dev_log/ulog_file_format.html>: every topic is a table with a
//! clock of its own.
//!
//! Columns are `vehicle_attitude.q[0]`; the second instance of a topic is called `sensor_accel_1`. Time is the
//! `timestamp` of a message, in seconds since the log began.

use std::{
    collections::{BTreeMap, HashSet},
    fs::File,
    io::{BufReader, Read},
};

use super::message::{
    Bytes, Count, Definitions, Field, Kind, NoMessage, Number, TopicColumns, decode,
};
use crate::{error::LogError, limit::Budget, recording::Recording, source::cannot_read};

const MAGIC: &[u8] = b"ULog\x01\x12\x35";

/// Reads all messages of data.
pub(super) fn read(file: &str, from: File) -> Result<Recording, LogError> {
    let mut reader = Reader { left: Budget::new(file), ..Reader::default() };
    reader.file(file, &mut BufReader::new(from)).map_err(|error| error.of(file, "ULog"))?;
    let mut recording = Recording { file: file.to_owned(), ..Recording::default() };
    for (_, topic) in reader.topics.into_values() {
        let (topics, unfit) = topic.finish();
        recording.unfit.extend(unfit);
        recording.topics.extend(topics.into_iter().filter(|topic| topic.rows() > 0));
    }
    if recording.topics.is_empty() {
        let (expected, found) = ("messages of data", "found none".to_owned());
        return Err(LogError::NoLog { file: file.to_owned(), expected, found });
    }
    Ok(recording)
}

#[derive(Debug, Default)]
struct Reader {
    left: Budget,
    definitions: Definitions,
    /// By number of the subscription: kind of its messages, and columns.
    topics: BTreeMap<u16, (String, TopicColumns)>,
    names: HashSet<String>,
    /// Microseconds of the clock at which the log begins.
    start: u64,
}

fn unsound(found: impl Into<String>) -> NoMessage {
    NoMessage::Unsound(found.into())
}

impl Reader {
    fn file(&mut self, file: &str, from: &mut impl Read) -> Result<(), NoMessage> {
        let cut = || unsound("the file ends too early");
        let mut head = [0; 16];
        from.read_exact(&mut head).map_err(|_| cut())?;
        let (magic, rest) = head.split_at(MAGIC.len());
        if magic != MAGIC {
            return Err(unsound(format!("found `{}` at its beginning", magic.escape_ascii())));
        }
        self.start = Bytes::dense(&rest[1..]).bits(8).ok_or_else(cut)?;
        let mut content = Vec::new();
        loop {
            let (length, kind) = match next(from, file, 3, &mut content)? {
                0 => return Ok(()),
                3 => (u16::from_le_bytes([content[0], content[1]]), content[2]),
                _ => return Err(cut()),
            };
            if next(from, file, length, &mut content)? != usize::from(length) {
                return Err(cut());
            }
            match kind {
                b'B' => check_flags(&content)?,
                b'F' => {
                    self.format(&content).ok_or_else(|| unsound("found a format without sense"))?;
                }
                b'A' => self.subscription(&content).ok_or_else(cut)?,
                b'D' => self.data(&content)?,
                // Texts, parameters, marks of lost messages and of places to go on from.
                _ => {}
            }
        }
    }

    /// `vehicle_attitude:uint64_t timestamp;float[4] q;`
    fn format(&mut self, content: &[u8]) -> Option<()> {
        let (name, fields) = std::str::from_utf8(content).ok()?.split_once(':')?;
        let fields = fields.split(';').filter(|field| !field.is_empty()).map(|field| {
            let (kind, name) = field.split_once(' ')?;
            let (base, count) = match kind.split_once('[') {
                None => (kind, Count::One),
                Some((base, size)) => (base, Count::Fixed(size.strip_suffix(']')?.parse().ok()?)),
            };
            let kind = match Number::parse(base) {
                // Letters, and what fills up to where the next number may begin.
                _ if base == "char" || name.starts_with("_padding") => Kind::Skipped,
                Some(number) => Kind::Number(number),
                None => Kind::Message(base.to_owned()),
            };
            Some(Field { name: name.to_owned(), kind, count })
        });
        let fields = fields.collect::<Option<Vec<_>>>()?;
        self.definitions.insert(name.to_owned(), fields);
        Some(())
    }

    fn subscription(&mut self, content: &[u8]) -> Option<()> {
        let (&instance, rest) = content.split_first()?;
        let (id, name) = rest.split_at_checked(2)?;
        let name = String::from_utf8_lossy(name).into_owned();
        let topic = if instance == 0 { name.clone() } else { format!("{name}_{instance}") };
        if self.names.insert(topic.clone()) {
            let id = u16::from_le_bytes([id[0], id[1]]);
            self.topics.insert(id, (name, TopicColumns::new(topic)));
        }
        Some(())
    }

    fn data(&mut self, content: &[u8]) -> Result<(), NoMessage> {
        let (id, data) = content.split_at_checked(2).unwrap_or_default();
        let id = id.try_into().map(u16::from_le_bytes).unwrap_or_default();
        let Some((kind, into)) = self.topics.get_mut(&id) else {
            return Err(unsound(format!("found data of topic {id}, which was not announced")));
        };
        let fields = self.definitions.get(kind).map(Vec::as_slice).unwrap_or_default();
        let is_stamped = fields.first().is_some_and(|field| field.name == "timestamp");
        let stamp = Bytes::dense(data).bits(8).filter(|_| is_stamped);
        let topic = into.name().to_owned();
        let stamp = stamp
            .ok_or_else(|| unsound(format!("found a message of `{topic}` without a time stamp")))?;
        let seconds = (i128::from(stamp) - i128::from(self.start)) as f64 * 1e-6;
        into.begin(seconds, &mut self.left)?;
        decode(kind, &self.definitions, Bytes::dense(data), 0, into, &mut self.left)
            .map_err(|error| error.in_topic(&topic))
    }
}

/// The next bytes, and how many there were.
fn next(
    from: &mut impl Read,
    file: &str,
    length: u16,
    content: &mut Vec<u8>,
) -> Result<usize, NoMessage> {
    content.clear();
    let read = from.take(u64::from(length)).read_to_end(content);
    read.map_err(|error| NoMessage::Large(cannot_read(file, &error)))
}

/// Flags that change what the rest means; data that was appended after a crash is read as any other.
fn check_flags(content: &[u8]) -> Result<(), NoMessage> {
    let unknown = content.get(8..16).unwrap_or_default().iter().enumerate();
    let mut unknown = unknown.filter(|(i, flags)| **flags & !u8::from(*i == 0) != 0);
    match unknown.next() {
        None => Ok(()),
        Some((i, flags)) => Err(unsound(format!("found unknown flags {flags:#04x} in byte {i}"))),
    }
}
