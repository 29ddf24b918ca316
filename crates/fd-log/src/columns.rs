//! From the column map and the header to the columns that are read.

use fd_model::{Channel, Circle, SampleTime, unit::Conversion};

use crate::{
    derived::{Derived, derived, derived_channel},
    error::LogError,
    header::{HeaderColumn, find, texts},
    map::{ColumnMap, LogMap, RowRule},
    source::LogSource,
};

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

/// Where the time of a row comes from.
#[derive(Debug)]
pub(super) enum Time {
    Column(Column),
    Rows(SampleTime),
}

pub(super) fn time_source(
    file: &str,
    header: &[HeaderColumn],
    dates: Option<usize>,
    map: &LogMap,
) -> Result<Time, LogError> {
    let index = match (&map.time.column, map.time.sample_time) {
        (Some(column), _) => find(file, header, column)?,
        (None, Some(ts)) => {
            let ts = SampleTime::new(ts).map_err(|source| LogError::TimeBase {
                file: file.to_owned(),
                column: None,
                source: Box::new(source.into()),
            })?;
            return Ok(Time::Rows(ts));
        }
        (None, None) => time_column(header, dates, map)
            .ok_or_else(|| LogError::NoTime { file: file.to_owned(), known: texts(header) })?,
    };
    let seconds = ColumnMap {
        name: header[index].text.clone(),
        unit: Some("s".to_owned()),
        column: Some(header[index].text.clone()),
        column_unit: map.time.unit.clone(),
        constant: None,
        expression: None,
        wraps: false,
    };
    Ok(Time::Column(resolve(file, header, map, &seconds)?.0))
}

/// The column of time: the one of the map, else one with a name that says so, else the one that holds dates.
pub(super) fn time_column(
    header: &[HeaderColumn],
    dates: Option<usize>,
    map: &LogMap,
) -> Option<usize> {
    if let Some(wanted) = &map.time.column {
        return header.iter().position(|column| column.text == *wanted || column.name == *wanted);
    }
    // A capital T is a temperature, unless its unit says otherwise.
    let is_time = |column: &HeaderColumn| {
        column.unit.as_deref().is_some_and(|unit| Conversion::between(unit, "s").is_ok())
    };
    let is_called = |column: &HeaderColumn, name: &str| {
        column.name == name
            || column.name.eq_ignore_ascii_case(name) && (name.len() > 1 || is_time(column))
    };
    let named = |name: &&str| header.iter().position(|column| is_called(column, name));
    ["time", "t", "time_s", "timestamp"].iter().find_map(named).or(dates)
}

/// Columns of the rules about rows, in the unit they have, and what is computed from columns.
pub(super) fn rule_columns(
    file: &str,
    header: &[HeaderColumn],
    map: &LogMap,
) -> Result<Vec<(RowRule, Column)>, LogError> {
    let column = |rule: &RowRule| {
        if let Some(text) = &rule.expression {
            return Ok((rule.clone(), rule_expression(file, header, map, rule, text)?));
        }
        let index = find(file, header, &rule.column)?;
        let text = header[index].text.clone();
        Ok((rule.clone(), Column::new(index, text, Conversion::IDENTITY)))
    };
    map.rules(file).map(column).collect()
}

/// An expression of a rule.
fn rule_expression(
    file: &str,
    header: &[HeaderColumn],
    map: &LogMap,
    rule: &RowRule,
    text: &str,
) -> Result<Column, LogError> {
    if !rule.column.is_empty() {
        return Err(wrong_rule(file, "expected it alone, found a `column` beside it"));
    }
    if rule.equals.or(rule.from).or(rule.until).is_none() {
        return Err(wrong_rule(file, "expected `equals`, `from` or `until` beside it, found none"));
    }
    derived(file, header, map, text, RULE)
}

/// What a rule with an expression is called.
const RULE: &str = "`rows`";

fn wrong_rule(file: &str, problem: &str) -> LogError {
    let (file, place, problem) = (file.to_owned(), RULE.to_owned(), problem.to_owned());
    LogError::Expression { file, place, problem }
}

/// Finds a column and settles its unit.
pub(super) fn resolve(
    file: &str,
    header: &[HeaderColumn],
    all: &LogMap,
    map: &ColumnMap,
) -> Result<(Column, Channel), LogError> {
    if let Some(text) = &map.expression {
        return derived_channel(file, header, all, map, text);
    }
    if let Some(number) = map.constant {
        return constant(file, map, number);
    }
    let index = find(file, header, map.column.as_ref().unwrap_or(&map.name))?;
    let HeaderColumn { text, unit: header_unit, .. } = &header[index];
    let column_unit = match (header_unit, &map.column_unit) {
        (Some(header), Some(map))
            if Conversion::between(header, map) != Ok(Conversion::IDENTITY) =>
        {
            let (file, column) = (file.to_owned(), text.clone());
            let (header, map) = (header.clone(), map.clone());
            return Err(LogError::UnitConflict { file, column, header, map });
        }
        (Some(unit), _) | (None, Some(unit)) => Some(unit),
        (None, None) => map.unit.as_ref(),
    };
    let column_unit = column_unit.map_or("1", String::as_str);
    let unit = map.unit.as_deref().unwrap_or(column_unit);
    let conversion = Conversion::between(column_unit, unit).map_err(|source| LogError::Unit {
        file: file.to_owned(),
        column: text.clone(),
        source,
    })?;
    Column::new(index, text.clone(), conversion).into_channel(file, map, unit)
}

/// A channel that is no column.
fn constant(file: &str, map: &ColumnMap, number: f64) -> Result<(Column, Channel), LogError> {
    let (file, text) = (file.to_owned(), map.name.clone());
    if map.column.is_some() || !number.is_finite() {
        return Err(LogError::Constant {
            file,
            channel: text,
            found: number,
            column: map.column.clone(),
        });
    }
    let unit = map.unit.as_deref().or(map.column_unit.as_deref()).unwrap_or("1");
    let from = map.column_unit.as_deref().unwrap_or(unit);
    match Conversion::between(from, unit) {
        Ok(conversion) => {
            let column = Column { constant: Some(number), ..Column::new(0, text, conversion) };
            column.into_channel(&file, map, unit)
        }
        Err(source) => Err(LogError::Unit { file, column: text, source }),
    }
}
