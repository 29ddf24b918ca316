//! Logs as the side of Python brings them: paths, and tables of arrays.

use std::path::PathBuf;

use fd_log::LogTable;
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;

use crate::errors::input;

/// A log: a file, or a name with columns in memory.
#[derive(FromPyObject)]
pub(crate) enum LogInput<'py> {
    /// Named columns.
    Table(String, Vec<(String, PyReadonlyArray1<'py, f64>)>),
    /// A file.
    File(PathBuf),
}

/// The names of the logs, and those among them that are tables.
pub(crate) fn named(
    py: Python<'_>,
    logs: Vec<LogInput<'_>>,
    tables: &mut Vec<LogTable>,
) -> PyResult<Vec<PathBuf>> {
    let each = logs.into_iter().map(|log| match log {
        LogInput::File(path) => Ok(path),
        LogInput::Table(name, columns) => {
            let values = |array: PyReadonlyArray1<'_, f64>| -> Vec<f64> {
                array.as_slice().map_or_else(|_| array.as_array().to_vec(), <[f64]>::to_vec)
            };
            let columns = columns.into_iter().map(|(column, array)| (column, values(array)));
            let table = LogTable::new(&name, columns).map_err(|error| input(py, &error))?;
            tables.push(table);
            Ok(PathBuf::from(name))
        }
    });
    each.collect()
}
