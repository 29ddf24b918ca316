//! Messages of protocol buffers, <https://protobuf.dev/programming-guides/encoding>, with their definition beside them: a
//! `FileDescriptorSet`, itself such a message.

use std::collections::BTreeMap;

use super::{NoMessage, TopicColumns};
use crate::limit::Budget;

/// Messages may be in messages this deep.
const DEEPEST: usize = 16;
/// Where nanoseconds and seconds since 1970 are one time, and one length of time.
const TIMESTAMP: &str = ".google.protobuf.Timestamp";
const DURATION: &str = ".google.protobuf.Duration";

/// Kinds of messages by full name, and their fields by number.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::format) struct Schema {
    root: String,
    messages: BTreeMap<String, BTreeMap<u64, Field>>,
}

#[derive(Clone, Debug, PartialEq)]
struct Field {
    name: String,
    kind: Kind,
    is_list: bool,
    /// Whether zero is what is not written (proto3).
    is_zero_if_missing: bool,
}

#[derive(Clone, Debug, PartialEq)]
enum Kind {
    Float(usize),
    /// Of seven bits a byte; with a sign in the lowest bit where it is `sint`.
    Varint {
        is_signed: bool,
        is_zigzag: bool,
    },
    Fixed {
        bytes: usize,
        is_signed: bool,
    },
    Text,
    Message(String),
    Other,
}

/// What a field has in the bytes.
#[derive(Clone, Copy)]
enum Wire<'a> {
    Number(u64),
    Bytes(&'a [u8]),
}

/// The next field: its number and content; nothing where the bytes are cut off or of an unknown form.
fn next<'a>(bytes: &mut &'a [u8]) -> Option<(u64, Wire<'a>)> {
    let tag = varint(bytes)?;
    let wire = match tag & 7 {
        0 => Wire::Number(varint(bytes)?),
        1 => Wire::Number(u64::from_le_bytes(taken(bytes, 8)?.try_into().ok()?)),
        2 => {
            let length = usize::try_from(varint(bytes)?).ok()?;
            Wire::Bytes(taken(bytes, length)?)
        }
        5 => Wire::Number(u32::from_le_bytes(taken(bytes, 4)?.try_into().ok()?).into()),
        _ => return None,
    };
    Some((tag >> 3, wire))
}

fn taken<'a>(bytes: &mut &'a [u8], count: usize) -> Option<&'a [u8]> {
    let (taken, rest) = bytes.split_at_checked(count)?;
    *bytes = rest;
    Some(taken)
}

fn varint(bytes: &mut &[u8]) -> Option<u64> {
    let mut number = 0;
    for place in 0..10 {
        let byte = taken(bytes, 1)?[0];
        number |= u64::from(byte & 0x7f) << (7 * place);
        if byte & 0x80 == 0 {
            return Some(number);
        }
    }
    None
}

/// All fields of a message.
fn fields(mut bytes: &[u8]) -> Option<Vec<(u64, Wire<'_>)>> {
    let mut all = Vec::new();
    while !bytes.is_empty() {
        all.push(next(&mut bytes)?);
    }
    Some(all)
}

fn text(wire: &Wire<'_>) -> Option<String> {
    match wire {
        Wire::Bytes(bytes) => Some(String::from_utf8_lossy(bytes).into_owned()),
        Wire::Number(_) => None,
    }
}

impl Schema {
    /// The definitions in a `FileDescriptorSet`; nothing if it is none, or does not define the root.
    pub(in crate::format) fn parse(root: &str, set: &[u8]) -> Option<Self> {
        let mut schema = Self { root: format!(".{root}"), ..Self::default() };
        for (_, file) in fields(set)?.into_iter().filter(|(number, _)| *number == 1) {
            let Wire::Bytes(file) = file else { return None };
            let file = fields(file)?;
            let one = |wanted| file.iter().find(|(number, _)| *number == wanted);
            let package = one(2).and_then(|(_, wire)| text(wire)).unwrap_or_default();
            let is_proto3 = one(12).and_then(|(_, wire)| text(wire)).as_deref() == Some("proto3");
            let within = if package.is_empty() { String::new() } else { format!(".{package}") };
            for (_, message) in file.iter().filter(|(number, _)| *number == 4) {
                let Wire::Bytes(message) = message else { return None };
                schema.message(message, &within, is_proto3, 0)?;
            }
        }
        schema.messages.contains_key(&schema.root).then_some(schema)
    }

    /// `DescriptorProto`: name 1, field 2, nested type 3.
    fn message(&mut self, bytes: &[u8], within: &str, is_proto3: bool, depth: usize) -> Option<()> {
        let parts = fields(bytes)?;
        let name =
            parts.iter().find(|(number, _)| *number == 1).and_then(|(_, wire)| text(wire))?;
        let name = format!("{within}.{name}");
        let mut own = BTreeMap::new();
        for (number, wire) in &parts {
            let Wire::Bytes(part) = wire else { continue };
            match number {
                2 => {
                    let (number, field) = field(part, is_proto3)?;
                    own.insert(number, field);
                }
                3 if depth < DEEPEST => self.message(part, &name, is_proto3, depth + 1)?,
                _ => {}
            }
        }
        self.messages.insert(name, own);
        Some(())
    }

    /// Puts the numbers of a message into the row that was begun. Bytes, texts and maps are passed over.
    pub(in crate::format) fn decode(
        &self,
        data: &[u8],
        start: u64,
        into: &mut TopicColumns,
        left: &mut Budget,
    ) -> Result<(), NoMessage> {
        let mut walk = Walk { schema: self, start, into, left, path: String::new() };
        walk.message(&self.root, data, 0)
    }
}

/// `FieldDescriptorProto`: name 1, number 3, label 4, type 5, type name 6, oneof 9, optional of proto3 17.
fn field(bytes: &[u8], is_proto3: bool) -> Option<(u64, Field)> {
    let parts = fields(bytes)?;
    let number = |wanted| {
        parts.iter().find_map(|(number, wire)| match wire {
            Wire::Number(value) if *number == wanted => Some(*value),
            _ => None,
        })
    };
    let text =
        |wanted| parts.iter().find(|(number, _)| *number == wanted).and_then(|(_, w)| text(w));
    let kind = match number(5)? {
        1 => Kind::Float(8),
        2 => Kind::Float(4),
        3 | 5 | 14 => Kind::Varint { is_signed: true, is_zigzag: false },
        4 | 8 | 13 => Kind::Varint { is_signed: false, is_zigzag: false },
        17 | 18 => Kind::Varint { is_signed: true, is_zigzag: true },
        6 => Kind::Fixed { bytes: 8, is_signed: false },
        7 => Kind::Fixed { bytes: 4, is_signed: false },
        15 => Kind::Fixed { bytes: 4, is_signed: true },
        16 => Kind::Fixed { bytes: 8, is_signed: true },
        9 => Kind::Text,
        11 => Kind::Message(text(6)?),
        _ => Kind::Other,
    };
    let is_list = number(4) == Some(3);
    let is_zero_if_missing = is_proto3 && !is_list && number(9).is_none();
    Some((number(3)?, Field { name: text(1)?, kind, is_list, is_zero_if_missing }))
}

struct Walk<'a> {
    schema: &'a Schema,
    start: u64,
    into: &'a mut TopicColumns,
    left: &'a mut Budget,
    path: String,
}

/// An entry of a list: a number that is packed with others, or what is by itself.
enum Entry<'a> {
    Number(f64),
    Wire(Wire<'a>),
}

fn unsound() -> NoMessage {
    NoMessage::Unsound("found a message that its definition does not describe".to_owned())
}

impl Kind {
    /// A number as it is written; nothing for what is none.
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_possible_wrap,
        reason = "the bits are those of shorter or signed numbers"
    )]
    fn number(&self, bits: u64) -> Option<f64> {
        Some(match self {
            Self::Float(8) => f64::from_bits(bits),
            Self::Float(_) => f32::from_bits(bits as u32).into(),
            Self::Varint { is_zigzag: true, .. } => {
                ((bits >> 1) as i64 ^ -((bits & 1) as i64)) as f64
            }
            Self::Varint { is_signed: true, .. } | Self::Fixed { bytes: 8, is_signed: true } => {
                bits as i64 as f64
            }
            Self::Fixed { is_signed: true, .. } => f64::from(bits as u32 as i32),
            Self::Varint { .. } | Self::Fixed { .. } => bits as f64,
            _ => return None,
        })
    }

    /// Numbers one behind the other, as lists of them are packed.
    fn packed(&self, mut bytes: &[u8]) -> Option<Vec<f64>> {
        let mut numbers = Vec::new();
        while !bytes.is_empty() {
            let bits = match self {
                Self::Float(length) | Self::Fixed { bytes: length, .. } => {
                    let taken = taken(&mut bytes, *length)?;
                    taken.iter().rev().fold(0, |bits: u64, byte| bits << 8 | u64::from(*byte))
                }
                Self::Varint { .. } => varint(&mut bytes)?,
                _ => return None,
            };
            numbers.push(self.number(bits)?);
        }
        Some(numbers)
    }
}

impl Walk<'_> {
    fn message(&mut self, kind: &str, bytes: &[u8], depth: usize) -> Result<(), NoMessage> {
        let Some(definition) = self.schema.messages.get(kind).filter(|_| depth <= DEEPEST) else {
            return Ok(());
        };
        let parts = fields(bytes).ok_or_else(unsound)?;
        if kind == TIMESTAMP || kind == DURATION {
            return self.time(kind == TIMESTAMP, &parts);
        }
        let of =
            |number: u64| parts.iter().filter(move |(n, _)| *n == number).map(|(_, wire)| *wire);
        let names = definition.iter().find(|(_, field)| field.name == "name" && field.is_list);
        let labels: Vec<String> =
            names.map_or(Vec::new(), |(number, _)| of(*number).filter_map(|w| text(&w)).collect());
        for (number, field) in definition {
            let before = self.path.len();
            if before > 0 {
                self.path.push('.');
            }
            self.path.push_str(&field.name);
            if field.is_list {
                self.list(field, of(*number), &labels, depth)?;
            } else if let Some(wire) = of(*number).next_back() {
                self.one(&field.kind, wire, depth)?;
            } else if let Some(zero) = field.kind.number(0).filter(|_| field.is_zero_if_missing) {
                self.into.put(&self.path, zero, self.left)?;
            }
            self.path.truncate(before);
        }
        Ok(())
    }

    fn list<'w>(
        &mut self,
        field: &Field,
        wires: impl Iterator<Item = Wire<'w>>,
        labels: &[String],
        depth: usize,
    ) -> Result<(), NoMessage> {
        let is_number = field.kind.number(0).is_some();
        let mut entries = Vec::new();
        for wire in wires {
            match wire {
                Wire::Bytes(bytes) if is_number => {
                    let numbers = field.kind.packed(bytes).ok_or_else(unsound)?;
                    entries.extend(numbers.into_iter().map(Entry::Number));
                }
                Wire::Number(bits) if is_number => {
                    entries.extend(field.kind.number(bits).map(Entry::Number));
                }
                other => entries.push(Entry::Wire(other)),
            }
        }
        let before = self.path.len();
        let is_labelled = labels.len() == entries.len();
        for (place, entry) in entries.into_iter().enumerate() {
            let label = labels.get(place).filter(|_| is_labelled);
            self.path += &label.map_or_else(|| format!("[{place}]"), |label| format!("[{label}]"));
            match entry {
                Entry::Number(number) => self.into.put(&self.path, number, self.left)?,
                Entry::Wire(wire) => self.one(&field.kind, wire, depth)?,
            }
            self.path.truncate(before);
        }
        Ok(())
    }

    fn one(&mut self, kind: &Kind, wire: Wire<'_>, depth: usize) -> Result<(), NoMessage> {
        match (kind, wire) {
            (Kind::Message(name), Wire::Bytes(bytes)) => self.message(name, bytes, depth + 1),
            (Kind::Text, Wire::Bytes(bytes)) => {
                self.into.note_frame(&self.path, &String::from_utf8_lossy(bytes));
                Ok(())
            }
            (kind, Wire::Number(bits)) => match kind.number(bits) {
                Some(number) => Ok(self.into.put(&self.path, number, self.left)?),
                None => Err(unsound()),
            },
            (Kind::Other, _) => Ok(()),
            _ => Err(unsound()),
        }
    }

    /// Seconds 1 and nanoseconds 2; a time counts from where the recording begins.
    #[allow(clippy::cast_possible_wrap, reason = "the bits are those of a signed number")]
    fn time(&mut self, is_date: bool, parts: &[(u64, Wire<'_>)]) -> Result<(), NoMessage> {
        let of = |wanted| {
            parts.iter().rev().find_map(|(number, wire)| match wire {
                Wire::Number(value) if *number == wanted => Some(i128::from(*value as i64)),
                _ => None,
            })
        };
        let nanos = of(1).unwrap_or(0) * 1_000_000_000 + of(2).unwrap_or(0);
        let from = if is_date { i128::from(self.start) } else { 0 };
        Ok(self.into.put(&self.path, (nanos - from) as f64 * 1e-9, self.left)?)
    }
}
