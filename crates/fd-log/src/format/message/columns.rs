//! The columns of one topic, as its messages bring them.

use std::collections::HashMap;

use crate::{error::LogError, header::HeaderColumn, limit::Budget, recording::Topic};

/// Most columns of one topic.
const MOST_COLUMNS: usize = 4096;

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

    /// The topic, with its name before every column; and what did not fit.
    pub(in crate::format) fn finish(self) -> (Topic, Option<(String, String)>) {
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
