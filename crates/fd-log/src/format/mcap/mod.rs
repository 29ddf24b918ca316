//! Recordings in MCAP, <https://mcap.dev/spec>: every topic whose messages are CDR with a definition in the file
//! (`ros2msg`), protocol buffers with theirs, or JSON is a table with a clock of its own.
//!
//! Columns are `/topic.field`, `/topic.list[0]`, and `/joint_states.position[elbow]` where the message names its
//! entries. Time is the time of logging, in seconds since the first message of the file; stamps inside messages are
//! columns that count from the same instant. Chunks may be packed by Zstandard or LZ4.

mod record;

use std::{
    collections::BTreeMap,
    fs::File,
    io::{BufReader, Read},
};

use lz4_flex::frame::FrameDecoder;

use self::record::{Content, HEAD, crc32};
use super::{
    message::{Definitions, NoMessage, Topics, definition, json, protobuf},
    zstd::Frames,
};
use crate::{error::LogError, recording::Recording, source::cannot_read};

const MAGIC: &[u8] = b"\x89MCAP0\r\n";
/// Most bytes of a record, and of a chunk unpacked.
const MOST_RECORD: u64 = 1 << 30;

const SCHEMA: u8 = 3;
const CHANNEL: u8 = 4;
const MESSAGE: u8 = 5;
const CHUNK: u8 = 6;
const ATTACHMENT: u8 = 9;
const DATA_END: u8 = 15;

/// Reads all messages that are columns.
pub(super) fn read(file: &str, from: File) -> Result<Recording, LogError> {
    let mut reader = Reader { topics: Topics::new(file), ..Reader::default() };
    reader.file(file, &mut BufReader::new(from)).map_err(|error| error.of(file, "MCAP"))?;
    reader.topics.finish(file)
}

/// What messages are made of.
#[derive(Debug)]
enum Schema {
    /// Name and definitions of ROS 2.
    Ros(String, Definitions),
    Protobuf(protobuf::Schema),
    /// Its name, and in what it is written.
    Other(String),
}

/// A topic, how its messages are written, and their schema.
#[derive(Debug)]
struct Channel {
    topic: String,
    encoding: String,
    schema: u16,
}

/// What is known of a file so far.
#[derive(Debug, Default)]
struct Reader {
    schemas: BTreeMap<u16, Schema>,
    channels: BTreeMap<u16, Channel>,
    topics: Topics,
}

fn unsound(found: impl Into<String>) -> NoMessage {
    NoMessage::Unsound(found.into())
}

fn cut() -> NoMessage {
    unsound("the file ends too early")
}

impl Reader {
    /// Most bytes of a record, and of a chunk unpacked: both are in memory while their messages are read.
    fn most(&self) -> u64 {
        MOST_RECORD.min(self.topics.left() / 2)
    }

    fn file(&mut self, file: &str, from: &mut impl Read) -> Result<(), NoMessage> {
        let mut magic = [0; MAGIC.len()];
        from.read_exact(&mut magic).map_err(|_| cut())?;
        if magic != MAGIC {
            return Err(unsound(format!("found `{}` at its beginning", magic.escape_ascii())));
        }
        loop {
            let mut head = [0; HEAD];
            from.read_exact(&mut head).map_err(|_| cut())?;
            let (kind, mut length) = (head[0], Content(&head[1..]));
            let length = length.u64().ok_or_else(cut)?;
            if kind == DATA_END {
                return Ok(());
            }
            if kind == ATTACHMENT {
                let skipped = std::io::copy(&mut from.take(length), &mut std::io::sink());
                if skipped.map_err(|error| cannot_read(file, &error))? != length {
                    return Err(cut());
                }
                continue;
            }
            let most = self.most();
            if length > most {
                let found = format!("found a record of {length} bytes, more than {most}");
                return Err(unsound(found));
            }
            let mut content = Vec::new();
            // Grows with what is there, not with what is claimed.
            let read = from.take(length).read_to_end(&mut content);
            if read.map_err(|error| cannot_read(file, &error))? as u64 != length {
                return Err(cut());
            }
            match kind {
                CHUNK => self.chunk(Content(&content))?,
                _ => self.record(kind, Content(&content))?,
            }
        }
    }

    /// Records that are packed together.
    fn chunk(&mut self, mut content: Content<'_>) -> Result<(), NoMessage> {
        let mut head = || {
            content.bytes(16)?;
            let (size, crc, packing) = (content.u64()?, content.u32()?, content.text()?);
            let length = content.u64()?;
            Some((size, crc, packing, content.bytes(length)?))
        };
        let (size, crc, packing, packed) = head().ok_or_else(cut)?;
        let most = self.most();
        if size > most {
            return Err(unsound(format!("found a chunk of {size} bytes, more than {most}")));
        }
        let mut unpacked = Vec::new();
        let read = match packing.as_str() {
            "" => packed.take(size + 1).read_to_end(&mut unpacked),
            "zstd" => Frames::new(packed).take(size + 1).read_to_end(&mut unpacked),
            "lz4" => FrameDecoder::new(packed).take(size + 1).read_to_end(&mut unpacked),
            other => return Err(unsound(format!("found a chunk that is packed by `{other}`"))),
        };
        read.map_err(|error| unsound(format!("found: {error}")))?;
        if unpacked.len() as u64 != size {
            let found = unpacked.len();
            return Err(unsound(format!(
                "found a chunk of {found} or more bytes instead of {size}"
            )));
        }
        if crc != 0 && crc != crc32(&unpacked) {
            return Err(unsound("found a chunk whose checksum does not fit"));
        }
        let mut records = Content(&unpacked);
        while !records.0.is_empty() {
            let (kind, content) = records.record().ok_or_else(cut)?;
            self.record(kind, content)?;
        }
        Ok(())
    }

    fn record(&mut self, kind: u8, content: Content<'_>) -> Result<(), NoMessage> {
        match kind {
            SCHEMA => self.schema(content).ok_or_else(cut),
            CHANNEL => self.channel(content).ok_or_else(cut),
            MESSAGE => self.message(content),
            _ => Ok(()),
        }
    }

    fn schema(&mut self, mut content: Content<'_>) -> Option<()> {
        let (id, name, encoding) = (content.u16()?, content.text()?, content.text()?);
        let length = content.u32()?;
        let data = content.bytes(u64::from(length))?;
        let parsed = match encoding.as_str() {
            "ros2msg" => definition::parse(&name, &String::from_utf8_lossy(data))
                .map(|definitions| Schema::Ros(definition::short(&name), definitions)),
            "protobuf" => protobuf::Schema::parse(&name, data).map(Schema::Protobuf),
            _ => None,
        };
        let other = || Schema::Other(format!("`{name}` ({encoding})"));
        self.schemas.insert(id, parsed.unwrap_or_else(other));
        Some(())
    }

    fn channel(&mut self, mut content: Content<'_>) -> Option<()> {
        let (id, schema, topic, encoding) =
            (content.u16()?, content.u16()?, content.text()?, content.text()?);
        self.channels.insert(id, Channel { topic, encoding, schema });
        Some(())
    }

    fn message(&mut self, mut content: Content<'_>) -> Result<(), NoMessage> {
        let mut head = || {
            let id = content.u16()?;
            content.u32()?;
            let time = content.u64()?;
            content.u64()?;
            Some((id, time))
        };
        let (id, time) = head().ok_or_else(cut)?;
        self.topics.note(time);
        let Some(Channel { topic, encoding, schema }) = self.channels.get(&id) else {
            return Ok(());
        };
        let channel = (u64::from(id), topic.as_str());
        match (encoding.as_str(), self.schemas.get(schema)) {
            ("cdr", Some(Schema::Ros(kind, definitions))) => {
                self.topics.add_cdr(channel, (kind, definitions), time, content.0)
            }
            ("protobuf", Some(Schema::Protobuf(schema))) => {
                self.topics.add(channel, time, |start, into, left| {
                    schema.decode(content.0, start, into, left)
                })
            }
            ("json", _) => self
                .topics
                .add(channel, time, |start, into, left| json::decode(content.0, start, into, left)),
            ("cdr" | "protobuf", other) => {
                let of = match other {
                    Some(Schema::Other(of)) => of.as_str(),
                    _ => "without a definition in the file",
                };
                self.topics.pass_over(topic, format!("messages of another kind: {of}"));
                Ok(())
            }
            (encoding, _) => {
                self.topics.pass_over(topic, format!("messages in {encoding}"));
                Ok(())
            }
        }
    }
}
