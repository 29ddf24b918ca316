//! A channel that is a column of the file, or a constant, and not computed from others.

use fd_model::{Channel, unit::Conversion};

use crate::{
    column::Column,
    error::LogError,
    header::{HeaderColumn, find},
    map::ColumnMap,
};

/// Finds a column and settles its unit.
pub(super) fn plain(
    file: &str,
    header: &[HeaderColumn],
    map: &ColumnMap,
) -> Result<(Column, Channel), LogError> {
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
