//! The columns of one topic, as its messages bring them.

use std::collections::HashMap;

use crate::{error::LogError, header::HeaderColumn, limit::Budget, recording::Topic};

/// Most columns of one topic.
const MOST_COLUMNS: usize = 4096;

/// Most sensors that send in turn on one topic; more are names of single messages.
const MOST_FRAMES: usize = 16;

/// Whether a text at this place names the sensor: `frame_id` of the header of a message, or of the message.
#[cfg(any(feature = "mcap", feature = "rosbag"))]
fn is_frame(path: &str) -> bool {
    path == "header.frame_id" || path == "frame_id"
}

/// A topic that grows message by message.
#[derive(Debug, Default)]
pub(in crate::format) struct TopicColumns {
    name: String,
    times: Vec<f64>,
    /// Places of columns by name.
    places: HashMap<String, usize>,
    names: Vec<String>,
    values: Vec<Vec<f64>>,
    has_too_many: bool,
    /// Names of frames, and which of them each row is in.
    frames: Vec<String>,
    frame_of: Vec<usize>,
}

impl TopicColumns {
    pub(in crate::format) fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), ..Self::default() }
    }

    pub(in crate::format) fn name(&self) -> &str {
        &self.name
    }

    /// Begins a row.
    pub(in crate::format) fn begin(
        &mut self,
        time: f64,
        left: &mut Budget,
    ) -> Result<(), LogError> {
        self.times.push(time);
        self.frame_of.push(usize::MAX);
        // A row has a value in every column, or will have.
        left.take(&format!("topic `{}`", self.name), 8 * (1 + self.values.len() as u64))
    }

    /// Puts a value into the row; the path is that of the field in its message.
    pub(super) fn put(
        &mut self,
        path: &str,
        value: f64,
        left: &mut Budget,
    ) -> Result<(), LogError> {
        let row = self.times.len().saturating_sub(1);
        let place = match self.places.get(path) {
            Some(place) => *place,
            None if self.values.len() >= MOST_COLUMNS => {
                self.has_too_many = true;
                return Ok(());
            }
            None => {
                left.take(&format!("topic `{}`", self.name), 8 * self.times.len() as u64)?;
                self.places.insert(path.to_owned(), self.values.len());
                self.names.push(path.to_owned());
                self.values.push(Vec::new());
                self.values.len() - 1
            }
        };
        let column = &mut self.values[place];
        // Messages without this field have no value; of a name that occurs twice the last counts.
        column.resize(row, f64::NAN);
        // Infinities are how robots say "no reading"; a log knows only missing values.
        column.push(if value.is_finite() { value } else { f64::NAN });
        Ok(())
    }

    /// Says that a text of the row is this; what is called `frame_id` at its top tells sensors from each other.
    #[cfg(any(feature = "mcap", feature = "rosbag"))]
    pub(super) fn note_frame(&mut self, path: &str, text: &str) {
        let Some(row) = self.frame_of.last_mut().filter(|_| is_frame(path)) else { return };
        let known = self.frames.iter().position(|frame| frame == text);
        *row = known.unwrap_or_else(|| {
            if self.frames.len() <= MOST_FRAMES {
                self.frames.push(text.to_owned());
            }
            self.frames.len() - 1
        });
    }

    /// The topic, with its name before every column; where several sensors send in turn, one topic for each, called
    /// `topic[frame]`. And what did not fit.
    pub(in crate::format) fn finish(mut self) -> (Vec<Topic>, Option<(String, String)>) {
        let frames = std::mem::take(&mut self.frames);
        if frames.len() < 2 || frames.len() > MOST_FRAMES {
            let (topic, unfit) = self.all();
            return (vec![topic], unfit);
        }
        let mut topics = Vec::new();
        for (number, frame) in frames.iter().enumerate() {
            let rows: Vec<usize> =
                (0..self.times.len()).filter(|row| self.frame_of[*row] == number).collect();
            let of = |column: &Vec<f64>| {
                rows.iter().map(|row| column.get(*row).copied().unwrap_or(f64::NAN)).collect()
            };
            let part = Self {
                name: format!("{}[{frame}]", self.name),
                times: of(&self.times),
                names: self.names.clone(),
                values: self.values.iter().map(of).collect(),
                has_too_many: self.has_too_many,
                ..Self::default()
            };
            topics.push(part.all().0);
        }
        let names: Vec<&str> = topics.iter().map(|topic| topic.name.as_str()).collect();
        let why = format!("several sensors in turn, by `frame_id`: {}", names.join(", "));
        let unfit = Some((self.name, why));
        (topics, unfit)
    }

    /// All rows as one topic.
    fn all(self) -> (Topic, Option<(String, String)>) {
        let Self { name, times, names, mut values, has_too_many, .. } = self;
        for column in &mut values {
            column.resize(times.len(), f64::NAN);
        }
        let header = |path: String| {
            let text = format!("{name}.{path}");
            // An index in brackets is no unit.
            HeaderColumn { name: text.clone(), text, unit: None }
        };
        let columns = names.into_iter().map(header).collect();
        let unfit = format!("more than {MOST_COLUMNS} columns, of which the first are read");
        let unfit = has_too_many.then(|| (name.clone(), unfit));
        (Topic { name, times: Some(times), columns, values }, unfit)
    }
}
