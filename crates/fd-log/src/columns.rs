//! From the column map and the header to the columns that are read.

use fd_model::{Channel, SampleTime, unit::Conversion};

use crate::{
    column::Column,
    derived::{derived, derived_channel},
    error::LogError,
    header::{HeaderColumn, find, texts},
    map::{ColumnMap, LogMap, RowRule},
    plain::plain,
};

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
    plain(file, header, map)
}
