//! Recordings of ROS 2 in `SQLite` (`rosbag2_storage_sqlite3`, `.db3`): every topic whose messages are CDR of a known
//! definition is a table with a clock of its own, as in MCAP.
//!
//! Definitions are in the file from ROS 2 Iron on. Older files have none: then those of usual messages (`standard`)
//! are taken, which have not changed since ROS 2 Foxy. Time is that of recording, from the first message of the file.

mod sqlite;
mod standard;

use std::{collections::BTreeMap, fs::File, path::Path};

use self::sqlite::{Database, Value};
use super::message::{Definitions, NoMessage, Topics, definition};
use crate::{error::LogError, recording::Recording};

/// What to do where definitions are missing.
const CONVERT: &str =
    "`ros2 bag convert` to MCAP, where ROS knows the message, writes it into the file";

/// Reads all messages that are columns.
pub(super) fn read(file: &str, from: File) -> Result<Recording, LogError> {
    // What was recorded last may be in a file beside, which SQLite itself has to bring in.
    for beside in [format!("{file}-wal"), format!("{file}-journal")] {
        if Path::new(&beside).metadata().is_ok_and(|about| 0 < about.len()) {
            let found = format!(
                "found `{beside}` beside it, which holds a part of it: open it once with SQLite"
            );
            return Err(LogError::Damaged { file: file.to_owned(), format: "SQLite", found });
        }
    }
    let mut topics = Topics::new(file);
    messages(from, &mut topics).map_err(|error| error.of(file, "SQLite"))?;
    topics.finish(file)
}

/// A table of the file: the page of its root, and its columns in order.
struct Table {
    root: u32,
    columns: Vec<String>,
}

impl Table {
    /// Names of columns out of `CREATE TABLE name(id INTEGER PRIMARY KEY, name TEXT NOT NULL, ...)`.
    fn new(root: u32, statement: &str) -> Self {
        let inner = statement.split_once('(').map_or("", |(_, inner)| inner);
        let first = |part: &str| {
            part.split_whitespace()
                .next()
                .unwrap_or_default()
                .trim_matches(['"', '`', '[', ']'])
                .to_owned()
        };
        Self { root, columns: inner.split(',').map(first).collect() }
    }

    /// Places of columns in a row.
    fn places<const N: usize>(&self, names: [&str; N]) -> Option<[usize; N]> {
        let mut places = [0; N];
        for (place, name) in places.iter_mut().zip(names) {
            *place = self.columns.iter().position(|column| column == name)?;
        }
        Some(places)
    }
}

fn no_bag(what: &str) -> NoMessage {
    NoMessage::Unsound(format!("found no {what}, as a recording of ROS 2 has"))
}

/// The number of a row is the value of its column `id`, which is then stored as none.
fn id(number: i64, value: Value<'_>) -> i64 {
    value.integer().unwrap_or(number)
}

fn messages(from: File, topics: &mut Topics) -> Result<(), NoMessage> {
    let mut database = Database::open(from)?;
    let tables = database.tables()?.into_iter();
    let tables: BTreeMap<String, Table> =
        tables.map(|(name, root, statement)| (name, Table::new(root, &statement))).collect();
    let known = definitions(&mut database, tables.get("message_definitions"))?;
    let usual = standard::definitions();

    // Topic and kind by number.
    let mut channels: BTreeMap<i64, (String, String)> = BTreeMap::new();
    let table = tables.get("topics").ok_or_else(|| no_bag("table `topics`"))?;
    let wanted = ["id", "name", "type", "serialization_format"];
    let places = table.places(wanted).ok_or_else(|| no_bag("columns of `topics`"))?;
    database.rows(table.root, &mut |number, values| {
        let [key, name, kind, format] =
            places.map(|place| values.get(place).copied().unwrap_or(Value::Null));
        let (Some(name), Some(kind), Some(format)) = (name.text(), kind.text(), format.text())
        else {
            return Err(no_bag("name and type of a topic"));
        };
        if format != "cdr" {
            topics.pass_over(name, format!("messages in {format}"));
        } else if known.contains_key(&kind) || usual.contains_key(&definition::short(&kind)) {
            channels.insert(id(number, key), (name, kind));
        } else {
            let why =
                format!("messages of `{kind}`, whose definition is not in the file: {CONVERT}");
            topics.pass_over(name, why);
        }
        Ok(())
    })?;

    let table = tables.get("messages").ok_or_else(|| no_bag("table `messages`"))?;
    let places = table.places(["topic_id", "timestamp", "data"]);
    let places = places.ok_or_else(|| no_bag("columns of `messages`"))?;
    database.rows(table.root, &mut |_, values| {
        let [topic, time, data] =
            places.map(|place| values.get(place).copied().unwrap_or(Value::Null));
        let (Some(topic), Some(time), Value::Bytes(data)) = (topic.integer(), time.integer(), data)
        else {
            return Err(no_bag("topic, time and data of a message"));
        };
        let (Ok(channel), Ok(time)) = (u64::try_from(topic), u64::try_from(time)) else {
            return Err(no_bag("topic and time of a message from 0 on"));
        };
        topics.note(time);
        let Some((name, kind)) = channels.get(&topic) else { return Ok(()) };
        let definitions = known.get(kind).unwrap_or(&usual);
        topics.add_cdr((channel, name), (&definition::short(kind), definitions), time, data)
    })
}

/// Definitions in the file, by the kind of message.
fn definitions(
    database: &mut Database,
    table: Option<&Table>,
) -> Result<BTreeMap<String, Definitions>, NoMessage> {
    let mut known = BTreeMap::new();
    let wanted = ["topic_type", "encoding", "encoded_message_definition"];
    let Some((table, places)) = table.and_then(|table| Some((table, table.places(wanted)?))) else {
        return Ok(known);
    };
    database.rows(table.root, &mut |_, values| {
        let [kind, encoding, text] =
            places.map(|place| values.get(place).and_then(|value| value.text()));
        if let (Some(kind), Some("ros2msg"), Some(text)) = (kind, encoding.as_deref(), text)
            && let Some(definitions) = definition::parse(&kind, &text)
        {
            known.insert(kind, definitions);
        }
        Ok(())
    })?;
    Ok(known)
}
