//! A gap study: what `fdiag gap` does, called from Python.

use std::{sync::Arc, time::Instant};

use fdiag::gap_study::{GapStudy, Signals, Timing, Trace};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::{prelude::*, types::PyDict};

use crate::{
    errors::{Class, analysis, input},
    log::{LogInput, named},
    settings::Settings,
    simulator::{Simulator, explained, explained_as},
    troubles::Troubles,
    watch,
};

/// Runs asked for, made and made again, steps, deaths and runs lost.
type Counts = (u64, u64, u64, u64, u64, u64);

/// A finished study.
#[pyclass(frozen, module = "fdiag._fdiag")]
#[derive(Debug)]
pub(crate) struct Study {
    study: GapStudy,
    simulator: Py<Simulator>,
}

/// Diagnoses logs: paths, or names with columns. `settings` is JSON; `progress` is called with a stage, what is
/// done, and of how much.
#[pyfunction]
#[pyo3(signature = (simulator, logs, held_out, settings, threads, progress, /))]
pub(crate) fn study(
    py: Python<'_>,
    simulator: Py<Simulator>,
    logs: Vec<LogInput<'_>>,
    held_out: Vec<LogInput<'_>>,
    settings: &str,
    threads: usize,
    progress: Option<Py<PyAny>>,
) -> PyResult<Study> {
    let settings = Settings::read(settings).map_err(|error| input(py, &error))?;
    let mut tables = Vec::new();
    let logs = [named(py, logs, &mut tables)?, named(py, held_out, &mut tables)?];
    let asked = simulator.get();
    let request = settings.request(asked.file().clone(), logs, tables);
    let request = request.map_err(|error| input(py, &error))?;
    let begun = Instant::now();
    let troubles = Arc::new(Troubles::default());
    let ended = watch::run(
        py,
        progress.as_ref(),
        || troubles.stop(),
        |watch| {
            // One state of the interpreter for the life of a thread: a new one for each call of a user's object would
            // cost ten times the call.
            rayon::ThreadPoolBuilder::new().num_threads(threads).build_scoped(
                |thread| Python::attach(|py| py.detach(|| thread.run())),
                |pool| {
                    let ended = pool.install(|| {
                        let subject = asked.subject(&request, &troubles)?;
                        GapStudy::run_on(&request, &subject, watch)
                    });
                    (ended, pool.current_num_threads())
                },
            )
        },
    )?;
    // However it went on after that: an exception of the user's code is the end.
    if troubles.is_stopped() {
        return Err(explained_as(py, Class::Simulator, "the simulator has failed", &troubles));
    }
    let (ended, threads) = ended.map_err(|error| analysis(py, &error))?;
    let mut study = ended.map_err(|error| explained(py, &error, &troubles))?;
    study.report.timing = Timing { seconds: begun.elapsed().as_secs_f64(), threads };
    Ok(Study { study, simulator })
}

#[pymethods]
impl Study {
    /// The text of `report.json`.
    fn json(&self, py: Python<'_>) -> PyResult<String> {
        fd_page::json(&self.study.report).map_err(|error| analysis(py, &error))
    }

    /// The text of `report.html`.
    fn html(&self, py: Python<'_>) -> PyResult<String> {
        let page = fd_page::page(&self.study).map_err(|error| analysis(py, &error))?;
        Ok(page.to_html())
    }

    /// The most telling picture as SVG.
    fn picture(&self, py: Python<'_>, width: u32, height: u32) -> PyResult<Option<String>> {
        fd_page::first_picture(&self.study, [width, height]).map_err(|error| analysis(py, &error))
    }

    /// Title, header and rows of each table that the command line prints.
    fn tables(&self) -> Vec<(String, Vec<String>, Vec<Vec<String>>)> {
        let tables = fd_page::tables(&self.study.report);
        tables.into_iter().map(|table| (table.title, table.header, table.rows)).collect()
    }

    /// Name and text of each patched model.
    fn models(&self) -> Vec<(String, String)> {
        let models = self.study.report.models.iter();
        models.map(|model| (model.file.clone(), model.text.clone())).collect()
    }

    /// The simulator with the cause in it, from a patched model.
    fn patched(&self, py: Python<'_>, file: &str, text: &str) -> Simulator {
        self.simulator.get().with_text(py, text, file)
    }

    /// Role, time in seconds, and name, unit, measured, simulated before and after of each output.
    fn trace<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<Option<(String, Bound<'py, PyArray1<f64>>, Vec<Bound<'py, PyDict>>)>> {
        let Some(Trace { role, time, outputs, .. }) = &self.study.trace else { return Ok(None) };
        let array = |values: &Vec<f64>| PyArray1::from_slice(py, values);
        let each = outputs.iter().map(|signals| {
            let Signals { name, unit, measured, before, after } = signals;
            let all = PyDict::new(py);
            all.set_item("name", name)?;
            all.set_item("unit", unit)?;
            for (key, values) in [("measured", measured), ("before", before), ("after", after)] {
                all.set_item(key, array(values))?;
            }
            Ok(all)
        });
        let role = format!("{role:?}").to_lowercase();
        Ok(Some((role, array(time), each.collect::<PyResult<_>>()?)))
    }

    /// Of the experiment that would tell the most: its place in the report's list, seconds between samples, and
    /// inputs `[samples, inputs]` in the units of the model.
    fn experiment<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<Option<(usize, f64, Bound<'py, PyArray2<f64>>)>> {
        let report = &self.study.report;
        let Some(advice) = &report.advice else { return Ok(None) };
        let tried = advice.tried.iter().enumerate();
        let most = tried.max_by(|(_, a), (_, b)| a.least().total_cmp(&b.least()));
        let Some(which) = advice.best.or(most.map(|(i, _)| i)) else { return Ok(None) };
        let (ts, u) = (report.inputs.sample_time_s, &advice.tried[which].experiment.u);
        let inputs = self.simulator.get().inputs(py)?;
        let rows = PyArray1::from_slice(py, u).reshape([u.len() / inputs.max(1), inputs])?;
        Ok(Some((which, ts, rows)))
    }

    /// What was asked of a simulator outside of Rust: runs asked for, made and made again, steps, deaths and runs
    /// lost; and what went wrong last.
    fn work(&self) -> Option<(Counts, f64, Option<String>)> {
        let (counts, trouble) = self.study.outside.as_ref()?;
        let numbers =
            [counts.asked, counts.made, counts.repeated, counts.steps, counts.deaths, counts.lost];
        let trouble = trouble.as_ref().map(ToString::to_string);
        Some((numbers.into(), counts.inside.as_secs_f64(), trouble))
    }
}
