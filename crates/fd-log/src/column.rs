//! A column that is read: one of the file, a constant, or one that is computed from others.

use fd_model::{Channel, Circle, unit::Conversion};
use fd_sim::equation::{Program, Workspace};

use crate::{error::LogError, map::ColumnMap, source::LogSource};

/// A column that is read.
#[derive(Debug)]
pub(super) struct Column {
    pub index: usize,
    pub text: String,
    pub conversion: Conversion,
    /// The number that it always has, if it is none of the file.
    pub constant: Option<f64>,
    /// How it is computed from others, if it is none of the file.
    pub derived: Option<Box<Derived>>,
    /// An angle goes on from its last value, without the jumps of one that begins anew after a turn.
    pub circle: Circle,
    pub last: f64,
}

impl Column {
    pub(super) fn new(index: usize, text: String, conversion: Conversion) -> Self {
        let (circle, last) = (Circle::LINE, f64::NAN);
        Self { index, text, conversion, constant: None, derived: None, circle, last }
    }

    /// The column and the channel that it becomes, in this unit.
    pub(super) fn into_channel(
        self,
        file: &str,
        map: &ColumnMap,
        unit: &str,
    ) -> Result<(Self, Channel), LogError> {
        let channel = Channel::new(&map.name, unit).wrapping(map.wraps);
        if map.wraps {
            // Only angles wrap.
            Conversion::between(unit, "rad").map_err(|source| LogError::Unit {
                file: file.to_owned(),
                column: self.text.clone(),
                source,
            })?;
        }
        Ok((Self { circle: channel.circle(), ..self }, channel))
    }

    /// Whether it is computed from the time of the row, too.
    pub(super) fn needs_time(&self) -> bool {
        self.derived.as_ref().is_some_and(|derived| derived.needs_time())
    }

    /// The number in the current row, in the unit of the channel.
    pub(super) fn number(&mut self, source: &impl LogSource, now: Moment) -> Result<f64, LogError> {
        let number = match (&mut self.derived, self.constant) {
            (Some(derived), _) => match derived.number(source, now)? {
                None => return Ok(f64::NAN),
                Some(number) if number.is_finite() => number,
                Some(number) => {
                    let (file, column) = (source.file().to_owned(), self.text.clone());
                    let found = number.to_string();
                    return Err(LogError::Number { file, column, row: now.row, found });
                }
            },
            (None, Some(number)) => number,
            (None, None) => source.number(self.index)?,
        };
        Ok(self.circle.go_on(self.conversion.apply(number), &mut self.last))
    }
}

/// Where a log is being read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moment {
    pub row: u64,
    /// Time of the row in seconds, once it is known.
    pub time: f64,
}

/// An expression, ready to be computed row by row.
#[derive(Debug)]
pub(super) struct Derived {
    pub program: Program,
    pub workspace: Workspace<f64>,
    /// What its names stand for, in the order of the workspace; `None` is the time.
    pub names: Vec<Option<Column>>,
    /// Whether the time is among them.
    pub needs_time: bool,
}

impl Derived {
    /// Whether it is computed from the time of the row, too.
    pub(super) fn needs_time(&self) -> bool {
        self.needs_time
    }

    /// The number of a row, in the unit of the expression; nothing where one of its columns has none.
    pub(super) fn number(
        &mut self,
        source: &impl LogSource,
        now: Moment,
    ) -> Result<Option<f64>, LogError> {
        let Self { program, workspace, names, needs_time } = self;
        let mut is_missing = false;
        for (value, column) in workspace.fast_mut().iter_mut().zip(names) {
            *value = match column {
                Some(column) => column.number(source, now)?,
                None => now.time,
            };
            is_missing |= value.is_nan() && (column.is_some() || *needs_time);
        }
        if is_missing {
            return Ok(None);
        }
        let mut results = [f64::NAN];
        program.run(workspace, &mut results);
        Ok(Some(results[0]))
    }
}
