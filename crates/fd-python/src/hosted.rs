//! A simulator in this process, for a diagnosis in another one.

use std::{
    collections::{HashMap, hash_map::Entry},
    sync::{Arc, Mutex, PoisonError},
};

use fd_model::SampleTime;
use fd_sim::{
    model::Model,
    outside::{Instance, Lane, Lost, OutsideError, OutsideSimulator, Start},
    simulate::{Nominal, Run, Simulator},
};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::{exceptions::PyConnectionError, prelude::*};

use crate::{
    errors::Class,
    simulator::{self, Ready, explained_as},
    troubles::Troubles,
};

/// Runs of a simulator, several side by side.
#[pyclass(frozen, module = "fdiag._fdiag")]
#[derive(Debug)]
pub(crate) struct Hosted {
    ready: Arc<Ready>,
    /// Makes another simulator for another lane; `None` where this one can be started more than once.
    more: Option<Py<PyAny>>,
    lanes: Mutex<Lanes>,
}

/// One instance for all lanes, or where an instance takes one run only, one each.
#[derive(Debug, Default)]
struct Lanes {
    instances: Vec<Box<dyn Instance>>,
    /// Lanes in which the simulator has refused to go on.
    is_over: Vec<bool>,
    /// Other simulators than the first one.
    others: Vec<Arc<Ready>>,
    /// Simulators in equations, by their text and the seconds between samples.
    shells: HashMap<(String, u64), Box<dyn Simulator>>,
}

/// So many simulators in equations are kept.
const SHELLS: usize = 64;

/// What is asked, in the words of [`RemoteInstance`](crate::remote::RemoteInstance).
struct Asked {
    op: String,
    starts: Vec<f64>,
    rows: Vec<f64>,
    runs: usize,
    samples: usize,
    around: Option<(String, f64)>,
}

type Answer = Result<[Vec<f64>; 2], Lost>;

impl Hosted {
    pub(crate) fn new(ready: Arc<Ready>, more: Option<Py<PyAny>>) -> Self {
        Self { ready, more, lanes: Mutex::default() }
    }

    /// Starts as many instances as there are lanes.
    fn open(&self, lanes: &mut Lanes, count: usize) -> Result<(), Lost> {
        while lanes.instances.len() < count {
            let another = match &self.more {
                Some(more) if !lanes.instances.is_empty() => Some(self.another(more)?),
                _ => None,
            };
            let ready = another.as_ref().unwrap_or(&self.ready);
            let Some(simulator) = ready.subject.outside() else { return Err(Lost::Refused) };
            let opened = simulator.instance();
            let opened = opened.map_err(|error: OutsideError| Lost::Broken(Box::new(error)))?;
            lanes.instances.push(opened);
            lanes.others.extend(another);
        }
        Ok(())
    }

    fn another(&self, more: &Py<PyAny>) -> Result<Arc<Ready>, Lost> {
        Python::attach(|py| {
            let made = || -> PyResult<Arc<Ready>> {
                more.call0(py)?.bind(py).cast::<simulator::Simulator>()?.get().ready(py)
            };
            made().map_err(|error| {
                let (simulator, what) = ("make".to_owned(), "another simulator".to_owned());
                let message = error.to_string();
                self.ready.troubles.raise(what.clone(), error);
                Lost::Broken(Box::new(OutsideError::Raised { simulator, what, message }))
            })
        })
    }

    fn answer(&self, asked: &Asked) -> Answer {
        let mut lanes = self.lanes.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(simulator) = self.ready.subject.outside() else { return Err(Lost::Refused) };
        if let Some((text, seconds)) = &asked.around {
            return lanes.in_equations(simulator, asked, (text, *seconds), &self.ready.troubles);
        }
        // Whole runs do not need to be side by side.
        let is_shared =
            asked.runs == 1 || 1 < simulator.contract().powers.lanes || asked.op == "rollout";
        self.open(&mut lanes, if is_shared { 1 } else { asked.runs })?;
        lanes.answer(simulator, asked, is_shared)
    }
}

#[pymethods]
impl Hosted {
    /// Outputs and states of `runs` runs, one after the other; `None` where the simulator refuses. `op` is `measure`, `step`
    /// or `rollout`. `starts` has number of the first step, parameters and initial states of each run that begins; none
    /// where they go on. `rows` has inputs, and unless it is `measure` forces, of each sample of each run.
    ///
    /// As `equations` it makes whole runs of this simulator in the equations of `around`, a model text and the seconds
    /// between samples: parameters are then those of the equations, and `rows` their inputs, the same for all runs.
    ///
    /// A simulator that has ended raises a `ConnectionError`.
    #[expect(clippy::too_many_arguments, reason = "one call is one message between two processes")]
    fn ask<'py>(
        &self,
        py: Python<'py>,
        op: String,
        starts: PyReadonlyArray1<'py, f64>,
        rows: PyReadonlyArray1<'py, f64>,
        runs: usize,
        samples: usize,
        around: Option<(String, f64)>,
    ) -> PyResult<Option<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>)>> {
        let [starts, rows] = [&starts, &rows].map(|a| a.as_array().iter().copied().collect());
        let asked = Asked { op, starts, rows, runs, samples, around };
        match py.detach(|| self.answer(&asked)) {
            Ok([y, x]) => Ok(Some((PyArray1::from_vec(py, y), PyArray1::from_vec(py, x)))),
            Err(Lost::Refused) => Ok(None),
            Err(Lost::Gone(error)) => Err(PyConnectionError::new_err(error.to_string())),
            Err(Lost::Broken(error)) => {
                let troubles = &self.ready.troubles;
                Err(explained_as(py, Class::Simulator, &error.to_string(), troubles))
            }
        }
    }
}

impl Lanes {
    /// The instances answer, the first one for all lanes or each for its own.
    fn answer(&mut self, simulator: &OutsideSimulator, asked: &Asked, is_shared: bool) -> Answer {
        let Asked { op, starts, rows, runs, samples, .. } = asked;
        let contract = simulator.contract();
        let (np, nx) = (contract.parameters.len(), contract.initial.len());
        let starts: Vec<Start<'_>> = starts.chunks_exact(1 + np + nx).map(taken(np)).collect();
        let sizes = (contract.outputs.len(), if contract.powers.states { nx } else { 0 });
        if op == "rollout" {
            return self.rollout(1 < simulator.lanes(), &starts, rows, *samples, sizes);
        }
        self.begin(is_shared, &starts)?;
        let (mut y, mut x) = (vec![f64::NAN; runs * sizes.0], vec![0.0; runs * sizes.1]);
        let is_step = op == "step";
        if is_shared {
            let instance = &mut self.instances[0];
            match (runs, is_step) {
                (1, true) => instance.step(rows, &mut y, &mut x)?,
                (1, false) => instance.measure(rows, &mut y)?,
                (_, true) => instance.step_lanes(*runs, rows, &mut y, &mut x)?,
                (_, false) => instance.measure_lanes(*runs, rows, &mut y)?,
            }
            return Ok([y, x]);
        }
        let width = rows.len() / runs;
        for (i, instance) in self.instances.iter_mut().enumerate().take(*runs) {
            if self.is_over[i] {
                continue;
            }
            let row = &rows[i * width..(i + 1) * width];
            let y = &mut y[i * sizes.0..(i + 1) * sizes.0];
            let x = &mut x[i * sizes.1..(i + 1) * sizes.1];
            let done = if is_step { instance.step(row, y, x) } else { instance.measure(row, y) };
            match done {
                Err(Lost::Refused) => {
                    self.is_over[i] = true;
                    y.fill(f64::NAN);
                }
                done => done?,
            }
        }
        Ok([y, x])
    }

    /// Whole runs in equations, as one machine makes them.
    fn in_equations(
        &mut self,
        simulator: &OutsideSimulator,
        asked: &Asked,
        (text, seconds): (&str, f64),
        troubles: &Troubles,
    ) -> Answer {
        let failed = |error: &dyn ToString| {
            let (simulator, what) = (simulator.contract().name.clone(), "equations".to_owned());
            let message = error.to_string();
            Lost::Broken(Box::new(OutsideError::Raised { simulator, what, message }))
        };
        let key = (text.to_owned(), seconds.to_bits());
        if SHELLS <= self.shells.len() && !self.shells.contains_key(&key) {
            self.shells.clear();
        }
        let shell = match self.shells.entry(key) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(room) => {
                let model: Model = text.parse().map_err(|error| failed(&error))?;
                let ts = SampleTime::new(seconds).map_err(|error| failed(&error))?;
                let made = simulator.shell().and_then(|shell| shell.patched(&model, ts));
                room.insert(made.map_err(|error| failed(&error))?)
            }
        };
        let Asked { starts, rows, runs, samples, .. } = asked;
        let (np, nx, ny) = (shell.parameters().len(), shell.initial().len(), shell.outputs().len());
        let starts: Vec<Start<'_>> = starts.chunks_exact(1 + np + nx).map(taken(np)).collect();
        let first = starts.first().map_or(0, |start| start.first);
        let mut y = vec![f64::NAN; runs * samples * ny];
        let places = y.chunks_exact_mut((samples * ny).max(1));
        let mut all: Vec<Run<'_>> =
            starts.iter().zip(places).map(|(s, y)| Run::new(s.theta, s.x0, y)).collect();
        shell.simulate_many(first, rows, &mut all);
        if simulator.is_given_up() || troubles.is_stopped() {
            let trouble = simulator.trouble();
            return Err(
                trouble.map_or_else(|| failed(&"it was given up"), |e| Lost::Broken(Box::new(e)))
            );
        }
        Ok([y, Vec::new()])
    }

    fn begin(&mut self, is_shared: bool, starts: &[Start<'_>]) -> Result<(), Lost> {
        if starts.is_empty() {
            return Ok(());
        }
        match (is_shared, starts) {
            (true, [start]) => return self.instances[0].reset(*start),
            (true, _) => return self.instances[0].reset_lanes(starts),
            (false, _) => {}
        }
        self.is_over = vec![false; starts.len()];
        for (i, (instance, start)) in self.instances.iter_mut().zip(starts).enumerate() {
            match instance.reset(*start) {
                Err(Lost::Refused) => self.is_over[i] = true,
                done => done?,
            }
        }
        Ok(())
    }

    /// Whole runs, in one call where the simulator takes several.
    fn rollout(
        &mut self,
        is_stacked: bool,
        starts: &[Start<'_>],
        rows: &[f64],
        samples: usize,
        (ny, nx): (usize, usize),
    ) -> Answer {
        let instance = &mut self.instances[0];
        let runs = starts.len().max(1);
        let mut y = vec![f64::NAN; runs * samples * ny];
        let mut x = vec![0.0; nx];
        let width = rows.len() / runs;
        let each = y.chunks_exact_mut((samples * ny).max(1)).enumerate().zip(starts);
        let mut lanes: Vec<Lane<'_>> = each
            .map(|((i, y), start)| Lane {
                start: *start,
                rows: &rows[i * width..(i + 1) * width],
                y,
            })
            .collect();
        if let [lane] = &mut lanes[..] {
            instance.rollout(lane.start, lane.rows, samples, lane.y, &mut x)?;
        } else if is_stacked {
            instance.rollouts(samples, &mut lanes)?;
        } else {
            for Lane { start, rows, y } in lanes {
                match instance.rollout(start, rows, samples, y, &mut x) {
                    Err(Lost::Refused) => y.fill(f64::NAN),
                    done => done?,
                }
            }
        }
        Ok([y, x])
    }
}

/// A start out of numbers.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a count, as it was packed"
)]
fn taken(parameters: usize) -> impl Fn(&[f64]) -> Start<'_> {
    move |numbers| {
        let (theta, x0) = numbers[1..].split_at(parameters);
        Start { theta, x0, first: numbers[0] as u64 }
    }
}
