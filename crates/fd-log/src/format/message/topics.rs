//! The topics of a recording of ROS 2, as its messages bring them.

use std::collections::{BTreeMap, HashSet};

use super::{Bytes, Definitions, NoMessage, TopicColumns, decode};
use crate::{error::LogError, limit::Budget, recording::Recording};

/// What is known of a recording so far.
#[derive(Debug, Default)]
pub(in crate::format) struct Topics {
    left: Budget,
    /// By channel: two of them may have one topic, and then are two clocks of it.
    by_channel: BTreeMap<u64, TopicColumns>,
    unfit: HashSet<(String, String)>,
    /// Nanoseconds since 1970 of the first message.
    start: Option<u64>,
}

impl Topics {
    pub(in crate::format) fn new(file: &str) -> Self {
        Self { left: Budget::new(file), ..Self::default() }
    }

    /// What is left of the memory for the file, in bytes.
    #[cfg(feature = "mcap")]
    pub(in crate::format) fn left(&self) -> u64 {
        self.left.left()
    }

    /// A topic that is no columns, and why.
    pub(in crate::format) fn pass_over(&mut self, topic: impl Into<String>, why: String) {
        self.unfit.insert((topic.into(), why));
    }

    /// Says that there was a message: clocks count from the first one, whatever its topic.
    pub(in crate::format) fn note(&mut self, time: u64) {
        self.start.get_or_insert(time);
    }

    /// Adds a message; `time` in nanoseconds since 1970. `decode` puts its numbers into the row, and is told where the
    /// recording begins.
    pub(in crate::format) fn add(
        &mut self,
        (channel, topic): (u64, &str),
        time: u64,
        decode: impl FnOnce(u64, &mut TopicColumns, &mut Budget) -> Result<(), NoMessage>,
    ) -> Result<(), NoMessage> {
        let start = *self.start.get_or_insert(time);
        let into = self.by_channel.entry(channel).or_insert_with(|| TopicColumns::new(topic));
        // One that was logged earlier than the first comes before 0.
        let seconds = (i128::from(time) - i128::from(start)) as f64 * 1e-9;
        into.begin(seconds, &mut self.left)?;
        decode(start, into, &mut self.left).map_err(|error| error.in_topic(topic))
    }

    /// Adds a message in CDR of a kind.
    pub(in crate::format) fn add_cdr(
        &mut self,
        of: (u64, &str),
        (kind, definitions): (&str, &Definitions),
        time: u64,
        data: &[u8],
    ) -> Result<(), NoMessage> {
        let bytes = Bytes::cdr(data).ok_or_else(|| {
            NoMessage::Unsound(format!("found a message of `{}` that is no CDR", of.1))
        })?;
        self.add(of, time, |start, into, left| decode(kind, definitions, bytes, start, into, left))
    }

    /// All of it.
    pub(in crate::format) fn finish(self, file: &str) -> Result<Recording, LogError> {
        let mut recording = Recording { file: file.to_owned(), ..Recording::default() };
        for topic in self.by_channel.into_values() {
            let (topics, unfit) = topic.finish();
            recording.unfit.extend(unfit);
            for topic in topics {
                // A topic of texts has messages and no columns.
                if topic.columns.is_empty() {
                    recording.unfit.push((topic.name, "messages without numbers".to_owned()));
                } else {
                    recording.topics.push(topic);
                }
            }
        }
        recording.unfit.extend(self.unfit);
        recording.with_columns("messages with numbers in them")
    }
}
