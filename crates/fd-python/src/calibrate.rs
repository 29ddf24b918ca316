//! All uncertain parameters of a simulator from logs: what `fdiag calibrate` does, called from Python.

use std::sync::Arc;

use fdiag::gap_study::calibrate_on;
use pyo3::prelude::*;
use serde_json::json;

use crate::{
    errors::{Class, analysis, input},
    log::{LogInput, named},
    settings::Settings,
    simulator::{Simulator, explained, explained_as},
    troubles::Troubles,
    watch,
};

/// Calibrates a simulator on logs: paths, or names with columns. `settings` is JSON, and so is the answer; behind it the text
/// of the simulator with the values in it.
#[pyfunction]
#[pyo3(signature = (simulator, logs, settings, /))]
pub(crate) fn calibrate(
    py: Python<'_>,
    simulator: Py<Simulator>,
    logs: Vec<LogInput<'_>>,
    settings: &str,
) -> PyResult<(String, String)> {
    let settings = Settings::read(settings).map_err(|error| input(py, &error))?;
    let mut tables = Vec::new();
    let logs = [named(py, logs, &mut tables)?, Vec::new()];
    let asked = simulator.get();
    let request = settings.request(asked.file().clone(), logs, tables);
    let request = request.map_err(|error| input(py, &error))?;
    let troubles = Arc::new(Troubles::default());
    let found = watch::run(
        py,
        None,
        || troubles.stop(),
        |_| {
            // One state of the interpreter for the life of the thread, as in a diagnosis.
            Python::attach(|py| {
                py.detach(|| calibrate_on(&request, &asked.subject(&request, &troubles)?))
            })
        },
    )?;
    if troubles.is_stopped() {
        return Err(explained_as(py, Class::Simulator, "the simulator has failed", &troubles));
    }
    let found = found.map_err(|error| explained(py, &error, &troubles))?;
    let answer = serde_json::to_string(&json!(found)).map_err(|error| analysis(py, &error))?;
    Ok((answer, found.text))
}
