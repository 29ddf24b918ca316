//! Which name is which column.

use std::collections::HashMap;

use fd_log::{ColumnMap, HeaderColumn, LogMap};
use fd_model::{
    nearest,
    unit::{Conversion, UnitError},
};
use thiserror::Error;

/// Most names of unknown columns that are remembered; further ones are left out without an event each.
const MOST_UNKNOWN: usize = 1000;
/// Names of a column of time when none is given.
const TIMES: [&str; 3] = ["time", "t", "time_s"];

/// Where time, unit and values of a sample are found.
///
/// ```
/// use fd_log::LogMap;
/// use fd_model::Channel;
/// use fd_watch::InputMap;
///
/// let map = LogMap::for_channels(&[Channel::new("wf", "kg/s")], &[Channel::new("T_7", "K")]);
/// let input = InputMap::new(map).with_units("engine");
/// assert_eq!(input.channels(), 2);
/// ```
#[derive(Clone, Debug)]
pub struct InputMap {
    map: LogMap,
    unit: Option<String>,
}

/// A name that was looked up.
#[derive(Clone, Copy, Debug)]
pub(super) enum Bound {
    Time(Conversion),
    Unit,
    Channel(usize, Conversion),
    Unknown,
}

/// The input cannot be understood at all.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ColumnsError {
    /// The unit of a column does not fit its channel.
    #[error("column `{column}`: {source}")]
    Unit {
        /// Name of the column.
        column: String,
        /// Why.
        source: UnitError,
    },
    /// Two columns would be the same channel.
    #[error(
        "the columns `{first}` and `{second}` are both {what}: name one of them in a column map"
    )]
    Twice {
        /// What they would be.
        what: String,
        /// The one that was there first.
        first: String,
        /// The other one.
        second: String,
    },
    /// The header of a CSV lacks a column.
    #[error("the header has no column for {what}{}", also(.nearest.as_deref()))]
    Missing {
        /// What is missing.
        what: String,
        /// A column that may have been meant.
        nearest: Option<String>,
    },
}

fn also(nearest: Option<&str>) -> String {
    nearest.map_or_else(String::new, |name| format!("; did you mean `{name}`?"))
}

impl InputMap {
    /// Columns of one unit that needs no name.
    #[must_use]
    pub fn new(map: LogMap) -> Self {
        Self { map, unit: None }
    }

    /// Samples of many units, told apart by this column.
    #[must_use]
    pub fn with_units(mut self, column: impl Into<String>) -> Self {
        self.unit = Some(column.into());
        self
    }

    /// Channels of a sample: inputs, then outputs.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.map.inputs.len() + self.map.outputs.len()
    }

    /// Separator of columns in CSV, if it is given.
    pub(super) fn delimiter(&self) -> Option<char> {
        self.map.delimiter
    }

    pub(super) fn has_decimal_comma(&self) -> bool {
        self.map.decimal_comma
    }

    pub(super) fn has_units(&self) -> bool {
        self.unit.is_some()
    }

    fn channel_maps(&self) -> impl Iterator<Item = &ColumnMap> {
        self.map.inputs.iter().chain(&self.map.outputs)
    }

    /// The column of a channel, as it is wanted.
    pub(super) fn wanted(&self, channel: usize) -> &str {
        self.channel_maps()
            .nth(channel)
            .map_or("", |map| map.column.as_deref().unwrap_or(&map.name))
    }

    fn is_time(&self, header: &HeaderColumn) -> bool {
        match &self.map.time.column {
            Some(column) => header.text == *column || header.name == *column,
            None => TIMES.iter().any(|time| header.name.eq_ignore_ascii_case(time)),
        }
    }

    /// What a name stands for.
    fn bind(&self, text: &str) -> Result<Bound, ColumnsError> {
        let header = HeaderColumn::parse(text);
        let is = |wanted: &str| header.text == wanted || header.name == wanted;
        let converted = |from: &Option<String>, to: &Option<String>| {
            let from = header.unit.as_ref().or(from.as_ref()).or(to.as_ref());
            let from = from.map_or("1", String::as_str);
            Conversion::between(from, to.as_deref().unwrap_or(from))
                .map_err(|source| ColumnsError::Unit { column: text.to_owned(), source })
        };
        if self.unit.as_deref().is_some_and(is) {
            return Ok(Bound::Unit);
        }
        let channel = (0..).zip(self.channel_maps()).find(|(i, _)| is(self.wanted(*i)));
        if let Some((index, map)) = channel {
            let from = map.column_unit.clone().or_else(|| map.unit.clone());
            return Ok(Bound::Channel(index, converted(&from, &map.unit)?));
        }
        if self.is_time(&header) {
            let seconds = Some("s".to_owned());
            return Ok(Bound::Time(converted(&self.map.time.unit, &seconds)?));
        }
        Ok(Bound::Unknown)
    }

    /// The wanted column that an unknown one may have been meant for.
    pub(super) fn nearest(&self, column: &str) -> Option<String> {
        let time = self.map.time.column.as_deref().unwrap_or("time");
        let wanted = (0..self.channels()).map(|i| self.wanted(i));
        let wanted = wanted.chain([time]).chain(self.unit.as_deref());
        nearest(&HeaderColumn::parse(column).name, wanted).into_iter().next()
    }
}

/// Names that were looked up before.
#[derive(Clone, Debug)]
pub(super) struct Columns {
    pub map: InputMap,
    known: HashMap<String, Bound>,
    unknown: usize,
}

impl Columns {
    pub(super) fn new(map: InputMap) -> Self {
        Self { map, known: HashMap::new(), unknown: 0 }
    }

    /// What a name stands for, and whether it is an unknown one that is new.
    pub(super) fn find(&mut self, name: &str) -> Result<(Bound, bool), ColumnsError> {
        if let Some(bound) = self.known.get(name) {
            return Ok((*bound, false));
        }
        let bound = self.map.bind(name)?;
        if !matches!(bound, Bound::Unknown) {
            let same = |other: &Bound| match (other, bound) {
                (Bound::Time(_), Bound::Time(_)) | (Bound::Unit, Bound::Unit) => true,
                (Bound::Channel(a, _), Bound::Channel(b, _)) => *a == b,
                _ => false,
            };
            if let Some((first, _)) = self.known.iter().find(|(_, other)| same(other)) {
                let what = match bound {
                    Bound::Channel(i, _) => format!("channel `{}`", self.map.wanted(i)),
                    Bound::Unit => "the unit".to_owned(),
                    _ => "time".to_owned(),
                };
                let (first, second) = (first.clone(), name.to_owned());
                return Err(ColumnsError::Twice { what, first, second });
            }
            self.known.insert(name.to_owned(), bound);
            return Ok((bound, false));
        }
        if self.unknown == MOST_UNKNOWN {
            return Ok((bound, false));
        }
        self.unknown += 1;
        self.known.insert(name.to_owned(), bound);
        Ok((bound, true))
    }
}
