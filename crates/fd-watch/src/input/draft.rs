//! A row while it is read.

use fd_model::Shown;

use super::{
    cells::Cell,
    columns::{Bound, Columns, ColumnsError, InputMap},
    runs::Runs,
};
use crate::message::What;

/// Most characters of the name of a unit.
const LONGEST_NAME: usize = 200;

/// A row while it is read.
#[derive(Clone, Debug)]
pub(super) struct Draft {
    pub columns: Columns,
    pub unit: String,
    has_unit: bool,
    pub time: Option<f64>,
    pub values: Vec<f64>,
    found: Vec<bool>,
    missing: Vec<Runs>,
    line: u64,
    pub events: Vec<What>,
}

impl Draft {
    pub(super) fn new(map: InputMap) -> Self {
        let channels = map.channels();
        Self {
            unit: String::new(),
            has_unit: false,
            time: None,
            values: vec![f64::NAN; channels],
            found: vec![false; channels],
            missing: vec![Runs::default(); channels],
            line: 0,
            events: Vec::new(),
            columns: Columns::new(map),
        }
    }

    pub(super) fn begin(&mut self) {
        self.line += 1;
        self.unit.clear();
        self.has_unit = false;
        self.time = None;
        self.values.fill(f64::NAN);
        self.found.fill(false);
    }

    pub(super) fn is_unreadable(&mut self, reason: &str) {
        let reason = Shown(reason).to_string();
        self.events.push(What::Unreadable { line: self.line, reason });
    }

    pub(super) fn find(&mut self, name: &str) -> Result<Bound, ColumnsError> {
        let (bound, is_new) = self.columns.find(name)?;
        if is_new {
            let (column, nearest) = (Shown(name).to_string(), self.columns.map.nearest(name));
            self.events.push(What::UnknownColumn { column, nearest });
        }
        Ok(bound)
    }

    pub(super) fn set_unit(&mut self, name: &str) -> Result<(), String> {
        if self.has_unit {
            return Err("the unit is there twice".to_owned());
        }
        if name.is_empty() || LONGEST_NAME < name.chars().count() {
            return Err(format!("the name of a unit has 1 to {LONGEST_NAME} characters"));
        }
        self.has_unit = true;
        self.unit.push_str(name);
        Ok(())
    }

    pub(super) fn set(&mut self, bound: Bound, cell: Cell) -> Result<(), String> {
        match (bound, cell) {
            // Names are read by `set_unit`, as they are.
            (Bound::Unknown | Bound::Unit, _) => {}
            (Bound::Time(_), _) if self.time.is_some() => {
                return Err("the time is there twice".to_owned());
            }
            (Bound::Time(conversion), Cell::Number(number)) => {
                self.time = Some(conversion.apply(number));
            }
            (Bound::Time(_), Cell::Missing) => return Err("it has no time".to_owned()),
            (Bound::Time(_), Cell::Text(text)) => {
                return Err(format!("the time is no number: `{}`", Shown(&text)));
            }
            (Bound::Channel(channel, conversion), cell) => {
                if std::mem::replace(&mut self.found[channel], true) {
                    return Err(format!("`{}` is there twice", self.columns.map.wanted(channel)));
                }
                match cell {
                    Cell::Number(number) => self.values[channel] = conversion.apply(number),
                    Cell::Missing => {}
                    Cell::Text(text) => {
                        let column = self.columns.map.wanted(channel).to_owned();
                        let (line, text) = (self.line, Shown(&text).to_string());
                        self.events.push(What::NotANumber { column, line, text });
                    }
                }
            }
        }
        Ok(())
    }

    /// Whether what was found is a row.
    pub(super) fn finish(&mut self) -> bool {
        if self.time.is_none() {
            self.is_unreadable("it has no time");
            return false;
        }
        if self.columns.map.has_units() && !self.has_unit {
            self.is_unreadable("it names no unit");
            return false;
        }
        for (channel, found) in self.found.iter().enumerate() {
            if *found {
                self.missing[channel] = Runs::default();
            } else if self.missing[channel].more().is_some() {
                let column = self.columns.map.wanted(channel).to_owned();
                self.events.push(What::MissingColumn { column, line: self.line });
            }
        }
        true
    }
}
