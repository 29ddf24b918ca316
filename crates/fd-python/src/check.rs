//! Whether a simulator is fit for a diagnosis.

use std::sync::Arc;

use fd_sim::outside::Grade;
use fdiag::gap_study::{Request, SimulatorCheck};
use pyo3::prelude::*;
use serde_json::json;

use crate::{
    errors::Class,
    errors::input,
    log::{LogInput, named},
    settings::Settings,
    simulator::{Simulator, explained, explained_as},
    troubles::Troubles,
    watch,
};

/// Checks a simulator through the inputs of the first log, or through steps of random height; the findings as JSON.
#[pyfunction]
#[pyo3(signature = (simulator, logs, settings, samples, amplitude, /))]
pub(crate) fn check(
    py: Python<'_>,
    simulator: Py<Simulator>,
    logs: Vec<LogInput<'_>>,
    settings: &str,
    samples: usize,
    amplitude: f64,
) -> PyResult<String> {
    let settings = Settings::read(settings).map_err(|error| input(py, &error))?;
    let mut tables = Vec::new();
    let logs = [named(py, logs, &mut tables)?, Vec::new()];
    let asked = simulator.get();
    let request = settings.request(asked.file().clone(), logs, tables);
    let request: Request = request.map_err(|error| input(py, &error))?;
    let troubles = Arc::new(Troubles::default());
    let checked = watch::run(
        py,
        None,
        || troubles.stop(),
        |_| {
            // One state of the interpreter for the life of the thread, as in a diagnosis.
            Python::attach(|py| {
                py.detach(|| {
                    let subject = asked.subject(&request, &troubles)?;
                    let outside = asked.started_anew(&subject, &troubles)?;
                    SimulatorCheck::of(&request, &subject, outside, (samples, amplitude))
                })
            })
        },
    )?;
    if troubles.is_stopped() {
        return Err(explained_as(py, Class::Simulator, "the simulator has failed", &troubles));
    }
    let check = checked.map_err(|error| explained(py, &error, &troubles))?;
    let grade = |grade: Grade| match grade {
        Grade::Fine => "fine",
        Grade::Doubt => "doubt",
        Grade::Broken => "broken",
    };
    let findings = check.findings.iter();
    let findings = findings.map(|found| json!([found.what, grade(found.grade), found.text]));
    let costs = check.costs.iter().map(|cost| json!([cost.what, cost.runs, cost.seconds]));
    Ok(json!({
        "findings": findings.collect::<Vec<_>>(),
        "samples": check.samples,
        "run": check.run,
        "steps": check.steps,
        "precision": check.precision,
        "costs": costs.collect::<Vec<_>>(),
        "trouble": check.trouble.as_ref().map(ToString::to_string),
        "note": troubles.noted(),
    })
    .to_string())
}
