//! What is diagnosed: the text of a model file, or an object of Python.

use std::{
    path::PathBuf,
    sync::{Arc, Mutex, PoisonError},
};

use fd_model::SampleTime;
use fd_sim::{
    outside::{Contract, OutsideError, OutsideSimulator, Stated},
    simulate::Outcome,
};
use fdiag::gap_study::{GapError, Request, Subject};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::{
    errors::{Class, class, input, raise},
    hosted::Hosted,
    lender::{Lender, Lending},
    troubles::Troubles,
};

/// A simulator, with or without effects in it.
#[pyclass(frozen, module = "fdiag._fdiag")]
#[derive(Debug)]
pub(crate) struct Simulator {
    kind: Kind,
    /// What it is called: a path, or a name.
    file: PathBuf,
    /// The subject that runs are asked of, once there was one.
    ready: Mutex<Option<Arc<Ready>>>,
}

#[derive(Debug)]
enum Kind {
    /// A model file.
    Text(String),
    /// An object of Python.
    Lent(Box<Lent>),
}

#[derive(Debug)]
struct Lent {
    contract: Contract,
    object: Py<PyAny>,
    takes_forces: bool,
    workers: usize,
    kind: Lending,
    /// Equations around it, with effects.
    equations: Option<String>,
}

impl Lent {
    fn started(&self, troubles: &Arc<Troubles>) -> Result<OutsideSimulator, OutsideError> {
        let object = Python::attach(|py| self.object.clone_ref(py));
        let (contract, troubles) = (self.contract.clone(), Arc::clone(troubles));
        let lender = Lender::new(contract.clone(), object, self.takes_forces, self.kind, troubles);
        OutsideSimulator::new(contract, lender, self.workers)
    }
}

/// A subject, and what went wrong with it.
#[derive(Debug)]
pub(crate) struct Ready {
    pub subject: Subject,
    pub troubles: Arc<Troubles>,
}

impl Simulator {
    fn new(kind: Kind, file: PathBuf) -> Self {
        Self { kind, file, ready: Mutex::new(None) }
    }

    /// What it is called.
    pub(crate) fn file(&self) -> &PathBuf {
        &self.file
    }

    /// A subject of its own for a request. Troubles of a user's code are noted in `troubles`.
    pub(crate) fn subject(
        &self,
        request: &Request,
        troubles: &Arc<Troubles>,
    ) -> Result<Subject, GapError> {
        match &self.kind {
            Kind::Text(text) => Subject::of_text(request, text),
            Kind::Lent(lent) => {
                Subject::lent(request, lent.started(troubles)?, lent.equations.as_deref())
            }
        }
    }

    /// The simulator outside of this program that it is, started for whoever asks; `None` for equations.
    pub(crate) fn started_anew(
        &self,
        subject: &Subject,
        troubles: &Arc<Troubles>,
    ) -> Result<Option<OutsideSimulator>, GapError> {
        match &self.kind {
            Kind::Text(_) => subject.started_anew(),
            Kind::Lent(lent) => Ok(Some(lent.started(troubles)?)),
        }
    }

    /// The same simulator with effects in it, from the text that a study has written.
    pub(crate) fn with_text(&self, py: Python<'_>, text: &str, file: &str) -> Self {
        let kind = match &self.kind {
            Kind::Text(_) => Kind::Text(text.to_owned()),
            Kind::Lent(lent) => Kind::Lent(Box::new(Lent {
                contract: lent.contract.clone(),
                object: lent.object.clone_ref(py),
                equations: Some(text.to_owned()),
                ..**lent
            })),
        };
        Self::new(kind, PathBuf::from(file))
    }

    /// How many inputs it has.
    pub(crate) fn inputs(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.ready(py)?.subject.channels()[0].len())
    }

    /// The subject that runs are asked of.
    pub(crate) fn ready(&self, py: Python<'_>) -> PyResult<Arc<Ready>> {
        let mut ready = self.ready.lock().unwrap_or_else(PoisonError::into_inner).clone();
        if let Some(ready) = ready.take().filter(|ready| !ready.troubles.is_stopped()) {
            return Ok(ready);
        }
        let troubles = Arc::new(Troubles::default());
        let request = Request::new(&self.file, Vec::<PathBuf>::new());
        let made = py.detach(|| self.subject(&request, &troubles));
        let subject = made.map_err(|error| explained(py, &error, &troubles))?;
        let ready = Arc::new(Ready { subject, troubles });
        *self.ready.lock().unwrap_or_else(PoisonError::into_inner) = Some(Arc::clone(&ready));
        Ok(ready)
    }
}

/// The exception of a study or run that failed: that of the user's code where there is one.
pub(crate) fn explained(py: Python<'_>, error: &GapError, troubles: &Troubles) -> PyErr {
    explained_as(py, class(error), &error.to_string(), troubles)
}

/// The same for a message of a class.
pub(crate) fn explained_as(
    py: Python<'_>,
    class: Class,
    message: &str,
    troubles: &Troubles,
) -> PyErr {
    if let Some((what, cause)) = troubles.take() {
        let error = raise(py, Class::Simulator, &format!("the simulator has failed in {what}"));
        error.set_cause(py, Some(cause));
        return error;
    }
    match troubles.noted() {
        Some(note) => {
            raise(py, Class::Simulator, &format!("{message}\nThe simulator was in trouble: {note}"))
        }
        None => raise(py, class, message),
    }
}

/// The simulator outside of Rust that a subject is.
fn outside<'a>(py: Python<'_>, ready: &'a Ready) -> PyResult<&'a OutsideSimulator> {
    let message = "expected a simulator outside of Rust, found equations, whose runs are made here in less time than asking \
                   for them elsewhere takes";
    ready.subject.outside().ok_or_else(|| raise(py, Class::Input, message))
}

#[pymethods]
impl Simulator {
    /// A model from the text of its file; relative paths in it begin where `file` is.
    #[staticmethod]
    fn from_text(text: String, file: PathBuf) -> Self {
        Self::new(Kind::Text(text), file)
    }

    /// An object of Python: `stated` is JSON of its channels, parameters, states, ports and powers.
    #[staticmethod]
    fn lent(
        py: Python<'_>,
        stated: &str,
        object: Py<PyAny>,
        takes_forces: bool,
        workers: usize,
        stacked: Option<usize>,
    ) -> PyResult<Self> {
        let stated: Stated = serde_json::from_str(stated).map_err(|error| input(py, &error))?;
        let name = stated.name.clone().unwrap_or_else(|| "simulator".to_owned());
        let contract = stated.contract(&format!("simulator `{name}`"));
        let contract = contract.map_err(|error: OutsideError| input(py, &error))?;
        let kind = stacked.map_or(Lending::Single, Lending::Stacked);
        let lent = Lent { contract, object, takes_forces, workers, kind, equations: None };
        let kind = Kind::Lent(Box::new(lent));
        Ok(Self::new(kind, PathBuf::from(name)))
    }

    /// This simulator, of which all runs are made elsewhere: `opener.open()` gives what `ask` of [`Hosted`] is asked
    /// through, `workers` at once, each for `lanes` runs in one call unless the simulator takes more.
    fn elsewhere(
        &self,
        py: Python<'_>,
        opener: Py<PyAny>,
        workers: usize,
        lanes: usize,
    ) -> PyResult<Self> {
        let ready = self.ready(py)?;
        let outside = outside(py, &ready)?;
        let mut contract = outside.contract().clone();
        let powers = &mut contract.powers;
        let lanes = if outside.lanes() == 1 { lanes } else { outside.lanes() };
        if powers.step && powers.lanes == 1 {
            powers.lanes = lanes;
        }
        // The host makes them of steps, where they are.
        powers.rollout = true;
        let (takes_forces, equations) = match &self.kind {
            Kind::Lent(lent) => (lent.takes_forces, lent.equations.clone()),
            Kind::Text(_) => (true, Some(ready.subject.model().to_string())),
        };
        let kind = Lending::Remote(lanes);
        let lent = Lent { contract, object: opener, takes_forces, workers, kind, equations };
        Ok(Self::new(Kind::Lent(Box::new(lent)), self.file.clone()))
    }

    /// This simulator for whoever asks for runs from elsewhere; `more()` makes another one like it, where this one
    /// cannot make several runs at the same time.
    fn hosted(&self, py: Python<'_>, more: Option<Py<PyAny>>) -> PyResult<Hosted> {
        let ready = self.ready(py)?;
        outside(py, &ready)?;
        Ok(Hosted::new(ready, more))
    }

    /// Name, time between samples, inputs, outputs and parameters with units, as JSON.
    fn described(&self, py: Python<'_>) -> PyResult<String> {
        let ready = self.ready(py)?;
        let subject = &ready.subject;
        let model = subject.model();
        let [inputs, outputs] = subject.channels();
        let ts = SampleTime::new(model.sample_time).map_err(|error| input(py, &error))?;
        let simulator = py.detach(|| subject.nominal().simulator(ts));
        let simulator = simulator.map_err(|error| input(py, &error))?;
        let channel = |c: &fd_model::Channel| serde_json::json!([c.name, c.unit]);
        let parameters = simulator.parameters().iter();
        let initial = simulator.initial().iter();
        let value = serde_json::json!({
            "name": model.name,
            "sample_time": model.sample_time,
            "inputs": inputs.iter().map(channel).collect::<Vec<_>>(),
            "outputs": outputs.iter().map(channel).collect::<Vec<_>>(),
            "parameters": parameters
                .map(|p| serde_json::json!([p.name, p.value, p.tolerance, p.unit]))
                .collect::<Vec<_>>(),
            "states": initial
                .map(|x| serde_json::json!([x.channel.name, x.value, x.channel.unit]))
                .collect::<Vec<_>>(),
        });
        Ok(value.to_string())
    }

    /// The text of its model file; of an object of Python, the equations around it.
    fn text(&self, py: Python<'_>) -> PyResult<String> {
        Ok(self.ready(py)?.subject.to_string())
    }

    /// Of a simulator outside of Rust: the values that its parameters get, those of its own effects last, and whether
    /// that is all that the equations around it do.
    fn handed_on(&self, py: Python<'_>) -> PyResult<(Vec<f64>, bool)> {
        let found = self.ready(py)?.subject.handed_on().map_err(|error| input(py, &error))?;
        found.ok_or_else(|| raise(py, Class::Input, "a model of equations hands nothing on"))
    }

    /// Outputs of a run through inputs `[samples, inputs]`, `sample_time` seconds apart; NaN from where it
    /// diverges.
    fn simulate<'py>(
        &self,
        py: Python<'py>,
        u: PyReadonlyArray2<'py, f64>,
        parameters: Vec<f64>,
        initial: Vec<f64>,
        sample_time: f64,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let ready = self.ready(py)?;
        let samples = u.shape()[0];
        let inputs: Vec<f64> =
            u.as_slice().map_or_else(|_| u.as_array().iter().copied().collect(), <[f64]>::to_vec);
        let ts = SampleTime::new(sample_time).map_err(|error| input(py, &error))?;
        let ran = py.detach(|| -> Result<(Vec<f64>, usize), GapError> {
            let mut simulator = ready.subject.nominal().simulator(ts)?;
            let ny = simulator.outputs().len();
            let mut y = vec![f64::NAN; samples * ny];
            let _: Outcome = simulator.simulate(&parameters, &initial, &inputs, &mut y);
            Ok((y, ny))
        });
        let (y, ny) = ran.map_err(|error| explained(py, &error, &ready.troubles))?;
        if ready.troubles.is_stopped() {
            return Err(explained_as(py, Class::Simulator, "the run was lost", &ready.troubles));
        }
        if let Some(trouble) = ready.subject.outside().and_then(OutsideSimulator::trouble)
            && y.iter().any(|value| !value.is_finite())
        {
            return Err(raise(py, Class::Simulator, &trouble.to_string()));
        }
        PyArray1::from_vec(py, y).reshape([samples, ny])
    }
}
