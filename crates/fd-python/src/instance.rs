//! One simulator that is an object of Python.

use std::sync::Arc;

use fd_sim::outside::{Contract, Instance, Lane, Lost, OutsideError, Start, by_lanes, by_steps};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::{
    exceptions::PyConnectionError,
    intern,
    prelude::*,
    types::{PyDict, PyString, PyTuple},
};

use crate::{
    troubles::{Troubles, is_divergence},
    values::{Unfit, fill},
};

/// An object with `reset` and `step`, or with `rollout`. The lock of the interpreter is held for each call.
#[derive(Debug)]
#[expect(clippy::struct_excessive_bools, reason = "each is a power of its own")]
pub(crate) struct PythonInstance {
    name: String,
    pub object: Py<PyAny>,
    pub inputs: usize,
    pub ports: usize,
    pub outputs: Vec<String>,
    pub parameters: Vec<String>,
    pub states: Vec<String>,
    pub shows_states: bool,
    rolls_out: bool,
    pub takes_forces: bool,
    /// Whether `rollout` takes stacked runs.
    pub is_stacked: bool,
    troubles: Arc<Troubles>,
    /// For messages: where it stands.
    at: String,
    pub samples: usize,
}

impl PythonInstance {
    pub(crate) fn new(
        contract: &Contract,
        object: Py<PyAny>,
        takes_forces: bool,
        troubles: Arc<Troubles>,
    ) -> Self {
        Self {
            name: contract.name.clone(),
            object,
            inputs: contract.inputs.len(),
            ports: contract.ports.len(),
            outputs: contract.outputs.iter().map(|output| output.name.clone()).collect(),
            parameters: contract.parameters.iter().map(|p| p.name.clone()).collect(),
            states: contract.initial.iter().map(|x| x.channel.name.clone()).collect(),
            shows_states: contract.powers.states,
            rolls_out: contract.powers.rollout,
            takes_forces,
            is_stacked: false,
            troubles,
            at: String::new(),
            samples: 0,
        }
    }

    fn named<'py>(
        py: Python<'py>,
        names: &[String],
        values: &[f64],
    ) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        for (name, value) in names.iter().zip(values) {
            all.set_item(name, value)?;
        }
        Ok(all)
    }

    /// Where a run begins, for messages.
    pub(crate) fn note_start(&mut self, start: Start<'_>) {
        let pairs = self.parameters.iter().zip(start.theta).map(|(p, v)| format!("{p} = {v}"));
        let pairs: Vec<String> = pairs.collect();
        self.at =
            if pairs.is_empty() { String::new() } else { format!(" at {}", pairs.join(", ")) };
        self.samples = 0;
    }

    pub(crate) fn broken(&self, what: &str, expected: String, found: String) -> Lost {
        let place = format!("simulator `{}`", self.name);
        let error = OutsideError::Value { place, key: what.to_owned(), expected, found };
        Lost::Broken(Box::new(error))
    }

    /// What an exception means: no numbers here, a simulator that is gone, or the end.
    pub(crate) fn lost(&self, py: Python<'_>, what: &str, error: PyErr) -> Lost {
        if is_divergence(py, &error) {
            return self.refused(what, &error);
        }
        if error.is_instance_of::<PyConnectionError>(py) {
            let (simulator, what) = (self.name.clone(), format!("`{what}`{}", self.at));
            self.troubles.note(|| format!("{what}: {error}"));
            let message = error.to_string();
            return Lost::Gone(Box::new(OutsideError::Raised { simulator, what, message }));
        }
        let message = error.to_string();
        let what = format!("`{what}`{}", self.at);
        self.troubles.raise(what.clone(), error);
        let error = OutsideError::Raised { simulator: self.name.clone(), what, message };
        Lost::Broken(Box::new(error))
    }

    /// No numbers here.
    pub(crate) fn refused(&self, what: &str, error: &PyErr) -> Lost {
        self.troubles.note(|| format!("`{what}`{}: {error}", self.at));
        Lost::Refused
    }

    /// Calls a method and takes its numbers.
    pub(crate) fn call<'py>(
        &self,
        py: Python<'py>,
        method: &Bound<'py, PyString>,
        arguments: &Bound<'py, PyTuple>,
        expected: impl FnOnce() -> String,
        into: &mut [f64],
    ) -> Result<(), Lost> {
        let what = || method.to_string_lossy().into_owned();
        let found = self.object.bind(py).call_method1(method, arguments);
        let found = found.map_err(|error| self.lost(py, &what(), error))?;
        fill(&found, into).map_err(|unfit| match unfit {
            Unfit::Raised(error) => self.lost(py, &what(), error),
            Unfit::Found(found) => self.broken(&format!("`{}`", what()), expected(), found),
        })
    }

    pub(crate) fn wanted(&self) -> String {
        let names = self.outputs.join("`, `");
        format!("{} numbers, the outputs `{names}`", self.outputs.len())
    }

    /// Work that was told to stop does no more.
    pub(crate) fn check(&self) -> Result<(), Lost> {
        if !self.troubles.is_stopped() {
            return Ok(());
        }
        let (simulator, what) = (self.name.clone(), "anything".to_owned());
        let message = "it was told to stop".to_owned();
        Err(Lost::Broken(Box::new(OutsideError::Raised { simulator, what, message })))
    }

    pub(crate) fn note_values(&self, y: &[f64], method: &str, sample: usize) {
        if let Some(i) = y.iter().position(|value| !value.is_finite()) {
            let (output, sample) =
                (&self.outputs[i % self.outputs.len()], sample + i / self.outputs.len());
            let (at, value) = (&self.at, y[i]);
            self.troubles.note(|| {
                format!("`{method}`{at}: expected finite outputs, found {value} in `{output}` at sample {sample}")
            });
        }
    }
}

impl Instance for PythonInstance {
    fn reset(&mut self, start: Start<'_>) -> Result<(), Lost> {
        self.check()?;
        self.note_start(start);
        if self.rolls_out {
            // Whole runs begin with their start.
            return Ok(());
        }
        if self.is_stacked {
            return self.begin_stacked(&[start]);
        }
        Python::attach(|py| {
            let made = || -> PyResult<()> {
                let parameters = Self::named(py, &self.parameters, start.theta)?;
                let states = Self::named(py, &self.states, start.x0)?;
                let object = self.object.bind(py);
                object.call_method1(intern!(py, "reset"), (parameters, states)).map(drop)
            };
            made().map_err(|error| self.lost(py, "reset", error))
        })
    }

    fn measure(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Lost> {
        self.check()?;
        if self.is_stacked {
            return self.measure_stacked(1, u, y);
        }
        Python::attach(|py| {
            let arguments = (PyArray1::from_slice(py, u),).into_pyobject(py);
            let arguments = arguments.map_err(|error| self.lost(py, "measure", error))?;
            self.call(py, intern!(py, "measure"), &arguments, || self.wanted(), y)
        })
    }

    fn step(&mut self, row: &[f64], y: &mut [f64], x: &mut [f64]) -> Result<(), Lost> {
        self.check()?;
        if self.is_stacked {
            return self.step_stacked(1, row, y, x);
        }
        Python::attach(|py| {
            let (u, f) = row.split_at(self.inputs);
            let u = PyArray1::from_slice(py, u);
            let arguments = if self.takes_forces {
                (u, PyArray1::from_slice(py, f)).into_pyobject(py)
            } else {
                (u,).into_pyobject(py)
            };
            let arguments = arguments.map_err(|error| self.lost(py, "step", error))?;
            self.call(py, intern!(py, "step"), &arguments, || self.wanted(), y)?;
            if self.shows_states {
                let wanted = || {
                    let names = self.states.join("`, `");
                    format!("{} numbers, the states `{names}`", self.states.len())
                };
                let none = PyTuple::empty(py);
                self.call(py, intern!(py, "state"), &none, wanted, x)?;
            }
            Ok(())
        })?;
        self.note_values(y, "step", self.samples);
        self.samples += 1;
        Ok(())
    }

    fn rollout(
        &mut self,
        start: Start<'_>,
        rows: &[f64],
        samples: usize,
        y: &mut [f64],
        x: &mut [f64],
    ) -> Result<(), Lost> {
        if self.rolls_out {
            return self.rollouts(samples, &mut [Lane { start, rows, y }]);
        }
        // One lock for all steps.
        Python::attach(|_| by_steps(self, start, rows, samples, y, x))
    }

    fn reset_lanes(&mut self, starts: &[Start<'_>]) -> Result<(), Lost> {
        self.check()?;
        if let Some(first) = starts.first() {
            self.note_start(*first);
        }
        self.begin_stacked(starts)
    }

    fn measure_lanes(&mut self, lanes: usize, u: &[f64], y: &mut [f64]) -> Result<(), Lost> {
        self.check()?;
        self.measure_stacked(lanes, u, y)
    }

    fn step_lanes(
        &mut self,
        lanes: usize,
        rows: &[f64],
        y: &mut [f64],
        x: &mut [f64],
    ) -> Result<(), Lost> {
        self.check()?;
        self.step_stacked(lanes, rows, y, x)
    }

    fn rollouts(&mut self, samples: usize, lanes: &mut [Lane<'_>]) -> Result<(), Lost> {
        self.check()?;
        if self.is_stacked && !self.rolls_out {
            // One lock for all steps.
            Python::attach(|_| by_lanes(self, samples, lanes))
        } else if self.is_stacked {
            self.stacked(samples, lanes)
        } else {
            lanes.iter_mut().try_for_each(|lane| self.alone(samples, lane))
        }
    }
}

/// Whole runs.
impl PythonInstance {
    /// Inputs, or forces, of a run, row by row.
    fn part(&self, rows: &[f64], from: usize, width: usize) -> Vec<f64> {
        let each = rows.chunks_exact((self.inputs + self.ports).max(1));
        each.flat_map(|row| row[from..from + width].iter().copied()).collect()
    }

    fn outputs_wanted(&self, shape: &str) -> String {
        format!("an array of shape [{shape}]: samples, outputs `{}`", self.outputs.join("`, `"))
    }

    /// One run in one call: dicts of numbers, and arrays `[samples, inputs]` and `[samples, ports]`.
    fn alone(&mut self, samples: usize, lane: &mut Lane<'_>) -> Result<(), Lost> {
        self.note_start(lane.start);
        let (nu, nf, ny) = (self.inputs, self.ports, self.outputs.len());
        let (u, f) = (self.part(lane.rows, 0, nu), self.part(lane.rows, nu, nf));
        Python::attach(|py| {
            let arguments = || -> PyResult<Bound<'_, PyTuple>> {
                let parameters = Self::named(py, &self.parameters, lane.start.theta)?;
                let states = Self::named(py, &self.states, lane.start.x0)?;
                let u = PyArray1::from_vec(py, u).reshape([samples, nu])?;
                if self.takes_forces {
                    let f = PyArray1::from_vec(py, f).reshape([samples, nf])?;
                    (parameters, states, u, f).into_pyobject(py)
                } else {
                    (parameters, states, u).into_pyobject(py)
                }
            };
            let arguments = arguments().map_err(|error| self.lost(py, "rollout", error))?;
            let wanted = || self.outputs_wanted(&format!("{samples}, {ny}"));
            self.call(py, intern!(py, "rollout"), &arguments, wanted, lane.y)
        })?;
        self.note_values(lane.y, "rollout", 0);
        Ok(())
    }

    /// Several runs in one call: dicts of arrays `[runs]`, and arrays `[runs, samples, inputs]` and
    /// `[runs, samples, ports]`.
    fn stacked(&mut self, samples: usize, lanes: &mut [Lane<'_>]) -> Result<(), Lost> {
        let Some(first) = lanes.first() else { return Ok(()) };
        self.note_start(first.start);
        let (nu, nf, ny) = (self.inputs, self.ports, self.outputs.len());
        let runs = lanes.len();
        let mut y = vec![0.0; runs * samples * ny];
        let all = |from: usize, width: usize| -> Vec<f64> {
            lanes.iter().flat_map(|lane| self.part(lane.rows, from, width)).collect()
        };
        let (u, f) = (all(0, nu), all(nu, nf));
        Python::attach(|py| {
            let named = |names: &[String], values: &dyn Fn(usize, usize) -> f64| {
                let all = PyDict::new(py);
                for (i, name) in names.iter().enumerate() {
                    let column: Vec<f64> = (0..runs).map(|lane| values(lane, i)).collect();
                    all.set_item(name, PyArray1::from_vec(py, column))?;
                }
                PyResult::Ok(all)
            };
            let arguments = || -> PyResult<Bound<'_, PyTuple>> {
                let theta = |lane: usize, i: usize| lanes[lane].start.theta[i];
                let x0 = |lane: usize, i: usize| lanes[lane].start.x0[i];
                let parameters = named(&self.parameters, &theta)?;
                let states = named(&self.states, &x0)?;
                let u = PyArray1::from_vec(py, u).reshape([runs, samples, nu])?;
                if self.takes_forces {
                    let f = PyArray1::from_vec(py, f).reshape([runs, samples, nf])?;
                    (parameters, states, u, f).into_pyobject(py)
                } else {
                    (parameters, states, u).into_pyobject(py)
                }
            };
            let arguments = arguments().map_err(|error| self.lost(py, "rollout", error))?;
            let wanted = || {
                self.outputs_wanted(&format!("{runs}, {samples}, {ny}")).replace("]: ", "]: runs, ")
            };
            self.call(py, intern!(py, "rollout"), &arguments, wanted, &mut y)
        })?;
        for (lane, y) in lanes.iter_mut().zip(y.chunks_exact(samples * ny)) {
            lane.y.copy_from_slice(y);
            self.note_start(lane.start);
            self.note_values(y, "rollout", 0);
        }
        Ok(())
    }
}
