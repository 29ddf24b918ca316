//! From the column map and the header to the columns that are read.

use fd_model::{Channel, SampleTime, unit::Conversion};

use crate::{
    error::LogError,
    header::{HeaderColumn, find, texts},
    map::{ColumnMap, LogMap, RowRule},
};

/// A column that is read.
#[derive(Clone, Debug)]
pub(super) struct Column {
    pub(super) index: usize,
    pub(super) text: String,
    pub(super) conversion: Conversion,
}

/// Where the time of a row comes from.
#[derive(Clone, Debug)]
pub(super) enum Time {
    Column(Column),
    Rows(SampleTime),
}

pub(super) fn time_source(
    file: &str,
    header: &[HeaderColumn],
    map: &LogMap,
) -> Result<Time, LogError> {
    let index = match (&map.time.column, map.time.sample_time) {
        (Some(column), _) => find(file, header, column)?,
        (None, Some(ts)) => {
            let ts = SampleTime::new(ts).map_err(|source| LogError::TimeBase {
                file: file.to_owned(),
                source: source.into(),
            })?;
            return Ok(Time::Rows(ts));
        }
        (None, None) => header
            .iter()
            .position(|c| ["time", "t", "time_s"].iter().any(|t| c.name.eq_ignore_ascii_case(t)))
            .ok_or_else(|| LogError::NoTime { file: file.to_owned(), known: texts(header) })?,
    };
    let seconds = ColumnMap {
        name: header[index].text.clone(),
        unit: Some("s".to_owned()),
        column: Some(header[index].text.clone()),
        column_unit: map.time.unit.clone(),
    };
    Ok(Time::Column(resolve(file, header, &seconds)?.0))
}

/// Columns of the rules about rows, in the unit they have.
pub(super) fn rule_columns(
    file: &str,
    header: &[HeaderColumn],
    rules: &[RowRule],
) -> Result<Vec<(RowRule, Column)>, LogError> {
    let column = |rule: &RowRule| {
        let index = find(file, header, &rule.column)?;
        let text = header[index].text.clone();
        Ok((rule.clone(), Column { index, text, conversion: Conversion::IDENTITY }))
    };
    rules.iter().map(column).collect()
}

/// Finds a column and settles its unit.
pub(super) fn resolve(
    file: &str,
    header: &[HeaderColumn],
    map: &ColumnMap,
) -> Result<(Column, Channel), LogError> {
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
    Ok((Column { index, text: text.clone(), conversion }, Channel::new(map.name.clone(), unit)))
}
