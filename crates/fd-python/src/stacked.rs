//! Objects of Python that step several runs in one call: everything has an axis of runs in front.

use fd_sim::outside::{Lost, Start};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::{
    intern,
    prelude::*,
    types::{PyDict, PyTuple},
};

use crate::instance::PythonInstance;

/// Values by name as arrays `[runs]`.
fn columns<'py>(
    py: Python<'py>,
    names: &[String],
    value: impl Fn(usize, usize) -> f64,
    runs: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    for (i, name) in names.iter().enumerate() {
        let column: Vec<f64> = (0..runs).map(|run| value(run, i)).collect();
        all.set_item(name, PyArray1::from_vec(py, column))?;
    }
    Ok(all)
}

impl PythonInstance {
    /// `reset(parameters, x0, runs)`.
    pub(crate) fn begin_stacked(&mut self, starts: &[Start<'_>]) -> Result<(), Lost> {
        self.samples = 0;
        Python::attach(|py| {
            let made = || -> PyResult<()> {
                let theta = |run: usize, i: usize| starts[run].theta[i];
                let x0 = |run: usize, i: usize| starts[run].x0[i];
                let parameters = columns(py, &self.parameters, theta, starts.len())?;
                let states = columns(py, &self.states, x0, starts.len())?;
                let arguments = (parameters, states, starts.len());
                self.object.bind(py).call_method1(intern!(py, "reset"), arguments).map(drop)
            };
            made().map_err(|error| self.lost(py, "reset", error))
        })
    }

    /// `measure(u) -> y`, arrays `[runs, inputs]` and `[runs, outputs]`.
    pub(crate) fn measure_stacked(
        &mut self,
        runs: usize,
        u: &[f64],
        y: &mut [f64],
    ) -> Result<(), Lost> {
        Python::attach(|py| {
            let u = PyArray1::from_slice(py, u).reshape([runs, self.inputs]);
            let arguments = u.and_then(|u| (u,).into_pyobject(py));
            let arguments = arguments.map_err(|error| self.lost(py, "measure", error))?;
            self.call(py, intern!(py, "measure"), &arguments, || self.wanted_of(runs), y)
        })
    }

    /// `step(u, f) -> y`, and then `state() -> x` where the object shows its states.
    pub(crate) fn step_stacked(
        &mut self,
        runs: usize,
        rows: &[f64],
        y: &mut [f64],
        x: &mut [f64],
    ) -> Result<(), Lost> {
        let (nu, nf) = (self.inputs, self.ports);
        let part = |from: usize, width: usize| -> Vec<f64> {
            let each = rows.chunks_exact((nu + nf).max(1));
            each.flat_map(|row| row[from..from + width].iter().copied()).collect()
        };
        let (u, f) = (part(0, nu), part(nu, nf));
        Python::attach(|py| {
            let arguments = || -> PyResult<Bound<'_, PyTuple>> {
                let u = PyArray1::from_vec(py, u).reshape([runs, nu])?;
                if self.takes_forces {
                    let f = PyArray1::from_vec(py, f).reshape([runs, nf])?;
                    (u, f).into_pyobject(py)
                } else {
                    (u,).into_pyobject(py)
                }
            };
            let arguments = arguments().map_err(|error| self.lost(py, "step", error))?;
            self.call(py, intern!(py, "step"), &arguments, || self.wanted_of(runs), y)?;
            if self.shows_states {
                let wanted = || {
                    let (n, names) = (self.states.len(), self.states.join("`, `"));
                    format!("an array of shape [{runs}, {n}]: runs, states `{names}`")
                };
                self.call(py, intern!(py, "state"), &PyTuple::empty(py), wanted, x)?;
            }
            Ok(())
        })?;
        self.note_values(y, "step", self.samples);
        self.samples += 1;
        Ok(())
    }

    fn wanted_of(&self, runs: usize) -> String {
        let (n, names) = (self.outputs.len(), self.outputs.join("`, `"));
        format!("an array of shape [{runs}, {n}]: runs, outputs `{names}`")
    }
}
