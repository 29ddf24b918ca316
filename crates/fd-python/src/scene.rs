//! A `MuJoCo` scene whose samples are taken without any code of Python in between.
//!
//! Inputs, forces, outputs and states are numbers in the memory of the scene, which numpy lends; a sample costs, beside
//! them, one or two calls of the wheel's own compiled `mj_step`. It is called through the interpreter, not by address:
//! the call is a fifth of a microsecond, and an error in `MuJoCo` (a stack that is full, say) is then an exception, where
//! a call by address would end the whole program.

use fd_sim::outside::{Instance, Lost, Start, by_steps};
use numpy::{PyArray1, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::{exceptions::PyIndexError, prelude::*, types::PyTuple};

use crate::instance::PythonInstance;

type Numbers = Py<PyArray1<f64>>;

/// Some of the numbers of an array in the memory of a scene.
#[derive(Debug)]
struct Places {
    array: Numbers,
    at: Vec<usize>,
}

impl Places {
    fn new(py: Python<'_>, array: Numbers, at: Vec<usize>) -> PyResult<Self> {
        let size = array.bind(py).len();
        if let Some(place) = at.iter().find(|place| size <= **place) {
            return Err(PyIndexError::new_err(format!(
                "expected a place below {size}, found {place}"
            )));
        }
        Ok(Self { array, at })
    }

    fn write(&self, py: Python<'_>, values: impl Iterator<Item = f64>) -> PyResult<()> {
        if self.at.is_empty() {
            return Ok(());
        }
        let mut array = self.array.bind(py).try_readwrite()?;
        let numbers = array.as_slice_mut()?;
        for (place, value) in self.at.iter().zip(values) {
            numbers[*place] = value;
        }
        Ok(())
    }

    fn read<'a>(&self, py: Python<'_>, into: impl Iterator<Item = &'a mut f64>) -> PyResult<()> {
        if self.at.is_empty() {
            return Ok(());
        }
        let array = self.array.bind(py).try_readonly()?;
        let numbers = array.as_slice()?;
        for (place, value) in self.at.iter().zip(into) {
            *value = numbers[*place];
        }
        Ok(())
    }
}

/// Outputs that are in one array: which of them, and where.
#[derive(Debug)]
struct Shown {
    to: Vec<usize>,
    of: Places,
}

impl Shown {
    fn read(&self, py: Python<'_>, y: &mut [f64]) -> PyResult<()> {
        let array = self.of.array.bind(py).try_readonly()?;
        let numbers = array.as_slice()?;
        for (to, of) in self.to.iter().zip(&self.of.at) {
            if let Some(output) = y.get_mut(*to) {
                *output = numbers[*of];
            }
        }
        Ok(())
    }
}

/// How the samples of a scene are taken: `scene.steps` of `fdiag._scene`.
#[pyclass(frozen, module = "fdiag._fdiag")]
#[derive(Debug)]
pub(crate) struct SceneSteps {
    /// `mj_step`, what it gets for the first time step of a sample, and for the others; without sensors there is one
    /// call for all.
    step: Py<PyAny>,
    first: Py<PyTuple>,
    others: Option<Py<PyTuple>>,
    forward: Py<PyAny>,
    model_and_data: Py<PyTuple>,
    controls: Places,
    forces: Places,
    /// Outputs that are there before a step …
    direct: Vec<Shown>,
    /// … and those that its first part computes.
    sensed: Vec<Shown>,
    warm_start: Numbers,
    positions: Places,
    velocities: Places,
}

#[pymethods]
impl SceneSteps {
    #[new]
    #[expect(clippy::too_many_arguments, reason = "the rooms of a scene")]
    fn new(
        py: Python<'_>,
        functions: (Py<PyAny>, Py<PyAny>),
        model: Py<PyAny>,
        data: Py<PyAny>,
        time_steps: usize,
        controls: (Numbers, Vec<usize>),
        forces: (Numbers, Vec<usize>),
        direct: Vec<(Numbers, Vec<usize>, Vec<usize>)>,
        sensed: Vec<(Numbers, Vec<usize>, Vec<usize>)>,
        warm_start: Numbers,
        states: ((Numbers, Vec<usize>), (Numbers, Vec<usize>)),
    ) -> PyResult<Self> {
        let shown = |all: Vec<(Numbers, Vec<usize>, Vec<usize>)>| -> PyResult<Vec<Shown>> {
            let one = |(array, to, of)| Ok(Shown { to, of: Places::new(py, array, of)? });
            all.into_iter().map(one).collect()
        };
        let call = |steps: usize| -> PyResult<Py<PyTuple>> {
            Ok((&model, &data, steps).into_pyobject(py)?.unbind())
        };
        let (step, forward) = functions;
        let is_split = !sensed.is_empty();
        let (positions, velocities) = states;
        Ok(Self {
            step,
            forward,
            first: call(if is_split { 1 } else { time_steps })?,
            others: (is_split && 1 < time_steps).then(|| call(time_steps - 1)).transpose()?,
            model_and_data: (&model, &data).into_pyobject(py)?.unbind(),
            controls: Places::new(py, controls.0, controls.1)?,
            forces: Places::new(py, forces.0, forces.1)?,
            direct: shown(direct)?,
            sensed: shown(sensed)?,
            warm_start,
            positions: Places::new(py, positions.0, positions.1)?,
            velocities: Places::new(py, velocities.0, velocities.1)?,
        })
    }
}

impl SceneSteps {
    /// Outputs of this sample; then on to the next.
    fn step(&self, py: Python<'_>, row: &[f64], y: &mut [f64]) -> PyResult<()> {
        let mut values = row.iter().copied();
        self.controls.write(py, values.by_ref().take(self.controls.at.len()))?;
        self.forces.write(py, values)?;
        self.direct.iter().try_for_each(|shown| shown.read(py, y))?;
        let step = self.step.bind(py);
        step.call1(self.first.bind(py))?;
        self.sensed.iter().try_for_each(|shown| shown.read(py, y))?;
        match &self.others {
            Some(others) => step.call1(others.bind(py)).map(drop),
            None => Ok(()),
        }
    }

    /// Outputs of this sample, without forces and without moving on.
    fn measure(&self, py: Python<'_>, u: &[f64], y: &mut [f64]) -> PyResult<()> {
        self.direct.iter().try_for_each(|shown| shown.read(py, y))?;
        if self.sensed.is_empty() {
            return Ok(());
        }
        self.controls.write(py, u.iter().copied())?;
        self.forces.write(py, std::iter::repeat(0.0))?;
        let warm_start = self.warm_start.bind(py);
        let kept = warm_start.try_readonly()?.as_slice()?.to_vec();
        self.forward.bind(py).call1(self.model_and_data.bind(py))?;
        warm_start.try_readwrite()?.as_slice_mut()?.copy_from_slice(&kept);
        self.sensed.iter().try_for_each(|shown| shown.read(py, y))
    }

    /// Position and velocity of each joint.
    fn state(&self, py: Python<'_>, x: &mut [f64]) -> PyResult<()> {
        self.positions.read(py, x.iter_mut().step_by(2))?;
        self.velocities.read(py, x.iter_mut().skip(1).step_by(2))
    }
}

/// One scene at work.
#[derive(Debug)]
pub(crate) struct SceneInstance {
    /// What begins its runs, and tells of its troubles.
    pub python: PythonInstance,
    pub steps: Py<SceneSteps>,
}

impl SceneInstance {
    /// What an exception in `MuJoCo` means. Its own errors (a stack that is full, a matrix that cannot be inverted) come from
    /// where the parameters lead: there are no numbers here.
    fn lost(&self, py: Python<'_>, what: &str, error: PyErr) -> Lost {
        let name = error.get_type(py).name();
        if name.is_ok_and(|name| name == "FatalError") {
            return self.python.refused(what, &error);
        }
        self.python.lost(py, what, error)
    }
}

impl Instance for SceneInstance {
    fn reset(&mut self, start: Start<'_>) -> Result<(), Lost> {
        self.python.reset(start)
    }

    fn measure(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Lost> {
        self.python.check()?;
        Python::attach(|py| {
            let done = self.steps.get().measure(py, u, y);
            done.map_err(|error| self.lost(py, "mj_forward", error))
        })
    }

    fn step(&mut self, row: &[f64], y: &mut [f64], x: &mut [f64]) -> Result<(), Lost> {
        self.python.check()?;
        Python::attach(|py| {
            let steps = self.steps.get();
            let done = steps.step(py, row, y).and_then(|()| match x {
                [] => Ok(()),
                x => steps.state(py, x),
            });
            done.map_err(|error| self.lost(py, "mj_step", error))
        })?;
        self.python.note_values(y, "mj_step", self.python.samples);
        self.python.samples += 1;
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
        // One lock for all steps.
        Python::attach(|_| by_steps(self, start, rows, samples, y, x))
    }
}
