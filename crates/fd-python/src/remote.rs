//! A simulator that runs in another process, as an object of Python passes requests on to it.

use fd_sim::{
    outside::{Instance, Lane, Lost, Start},
    simulate::{Around, Run},
};
use numpy::PyArray1;
use pyo3::{prelude::*, types::PyTuple};

use crate::{
    instance::PythonInstance,
    values::{Unfit, fill},
};

/// Asks `ask(op, starts, rows, runs, samples, around)` of an object, which a [`Hosted`](crate::hosted::Hosted) answers. One call
/// costs about as much as many steps, so a start goes with the call that comes after it.
#[derive(Debug)]
pub(crate) struct RemoteInstance {
    python: PythonInstance,
    /// Where the runs begin that have not begun yet.
    starts: Vec<f64>,
}

/// What is asked in a call.
#[derive(Clone, Copy)]
struct Ask<'a> {
    op: &'static str,
    rows: &'a [f64],
    runs: usize,
    samples: usize,
    /// Equations around the simulator, and seconds between samples.
    around: Option<(&'a str, f64)>,
}

/// A start as numbers, which `taken` takes apart again: the number of the first step is exact up to 2^53.
pub(crate) fn packed(start: &Start<'_>) -> impl Iterator<Item = f64> {
    [start.first as f64].into_iter().chain(start.theta.iter().copied()).chain(start.x0.to_vec())
}

impl RemoteInstance {
    pub(crate) fn new(python: PythonInstance) -> Self {
        Self { python, starts: Vec::new() }
    }

    fn ask(&mut self, ask: Ask<'_>, y: &mut [f64], x: &mut [f64]) -> Result<(), Lost> {
        self.python.check()?;
        let Ask { op, rows, runs, samples, around } = ask;
        let starts = std::mem::take(&mut self.starts);
        let python = &self.python;
        Python::attach(|py| {
            let starts = PyArray1::from_vec(py, starts);
            let rows = PyArray1::from_slice(py, rows);
            let arguments = (op, starts, rows, runs, samples, around);
            let answer = python.object.bind(py).call_method1("ask", arguments);
            let answer = answer.map_err(|error| python.lost(py, op, error))?;
            if answer.is_none() {
                return Err(Lost::Refused);
            }
            let found = answer.cast_into::<PyTuple>().map_err(PyErr::from);
            let found = found.map_err(|error| python.lost(py, op, error))?;
            for (i, into) in [y, x].into_iter().enumerate().filter(|(_, into)| !into.is_empty()) {
                let part = found.get_item(i).map_err(|error| python.lost(py, op, error))?;
                fill(&part, into).map_err(|unfit| match unfit {
                    Unfit::Raised(error) => python.lost(py, op, error),
                    Unfit::Found(found) => {
                        python.broken(op, format!("{} numbers", into.len()), found)
                    }
                })?;
            }
            Ok(())
        })
    }
}

impl Instance for RemoteInstance {
    fn reset(&mut self, start: Start<'_>) -> Result<(), Lost> {
        self.reset_lanes(&[start])
    }

    fn measure(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Lost> {
        self.measure_lanes(1, u, y)
    }

    fn step(&mut self, row: &[f64], y: &mut [f64], x: &mut [f64]) -> Result<(), Lost> {
        self.step_lanes(1, row, y, x)
    }

    fn rollout(
        &mut self,
        start: Start<'_>,
        rows: &[f64],
        samples: usize,
        y: &mut [f64],
        x: &mut [f64],
    ) -> Result<(), Lost> {
        self.reset(start)?;
        self.ask(Ask { op: "rollout", rows, runs: 1, samples, around: None }, y, x)
    }

    fn reset_lanes(&mut self, starts: &[Start<'_>]) -> Result<(), Lost> {
        self.python.check()?;
        if let Some(first) = starts.first() {
            self.python.note_start(*first);
        }
        self.starts = starts.iter().flat_map(packed).collect();
        Ok(())
    }

    fn measure_lanes(&mut self, lanes: usize, u: &[f64], y: &mut [f64]) -> Result<(), Lost> {
        self.ask(Ask { op: "measure", rows: u, runs: lanes, samples: 1, around: None }, y, &mut [])
    }

    fn step_lanes(
        &mut self,
        lanes: usize,
        rows: &[f64],
        y: &mut [f64],
        x: &mut [f64],
    ) -> Result<(), Lost> {
        self.ask(Ask { op: "step", rows, runs: lanes, samples: 1, around: None }, y, x)
    }

    fn in_equations(&mut self, around: Around<'_>, runs: &mut [Run<'_>]) -> Result<(), Lost> {
        let Around { model, ts, first, u, samples, .. } = around;
        let starts: Vec<Start<'_>> =
            runs.iter().map(|run| Start { theta: run.theta, x0: run.x0, first }).collect();
        self.reset_lanes(&starts)?;
        let text = model.to_string();
        let mut y = vec![0.0; runs.iter().map(|run| run.y.len()).sum()];
        let around = Some((text.as_str(), ts.seconds()));
        let ask = Ask { op: "equations", rows: u, runs: runs.len(), samples, around };
        self.ask(ask, &mut y, &mut [])?;
        let mut rest = &y[..];
        for run in runs {
            let (front, back) = rest.split_at(run.y.len());
            run.y.copy_from_slice(front);
            rest = back;
        }
        Ok(())
    }

    fn rollouts(&mut self, samples: usize, lanes: &mut [Lane<'_>]) -> Result<(), Lost> {
        let starts: Vec<Start<'_>> = lanes.iter().map(|lane| lane.start).collect();
        self.reset_lanes(&starts)?;
        let rows: Vec<f64> = lanes.iter().flat_map(|lane| lane.rows).copied().collect();
        let mut y = vec![0.0; lanes.iter().map(|lane| lane.y.len()).sum()];
        let ask = Ask { op: "rollout", rows: &rows, runs: lanes.len(), samples, around: None };
        self.ask(ask, &mut y, &mut [])?;
        let mut rest = &y[..];
        for lane in lanes {
            let (front, back) = rest.split_at(lane.y.len());
            lane.y.copy_from_slice(front);
            rest = back;
        }
        Ok(())
    }
}
