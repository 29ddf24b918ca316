//! An object of Python that lends runs, and what is remembered of its troubles.

use std::sync::{
    Arc, Mutex, MutexGuard, PoisonError,
    atomic::{AtomicBool, Ordering::Relaxed},
};

use fd_sim::outside::{Contract, Instance, OutsideError, Source};
use pyo3::{exceptions::PyArithmeticError, prelude::*};

use crate::{
    instance::PythonInstance,
    remote::RemoteInstance,
    scene::{SceneInstance, SceneSteps},
};

/// Starts simulators that are objects of Python: `open()` of the object gives one with `reset(parameters, x0)` and
/// `step(u[, f])`, or with `rollout(parameters, x0, u[, f])`, and perhaps `measure(u)` and `state()`.
#[derive(Debug)]
pub(crate) struct Lender {
    pub contract: Contract,
    pub object: Py<PyAny>,
    /// Whether its functions take forces.
    pub takes_forces: bool,
    pub kind: Lending,
    troubles: Arc<Troubles>,
}

/// How an object is asked for runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lending {
    /// One at a time.
    Single,
    /// So many at once, with an axis of runs in front.
    Stacked(usize),
    /// So many at once, of a simulator in another process.
    Remote(usize),
}

/// What went wrong in a user's code, and whether that is the end.
#[derive(Debug, Default)]
pub(crate) struct Troubles {
    stopped: AtomicBool,
    raised: Mutex<Option<(String, PyErr)>>,
    note: Mutex<Option<String>>,
}

fn open<T>(lock: &Mutex<T>) -> MutexGuard<'_, T> {
    lock.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Lender {
    pub(crate) fn new(
        contract: Contract,
        object: Py<PyAny>,
        takes_forces: bool,
        kind: Lending,
        troubles: Arc<Troubles>,
    ) -> Self {
        Self { contract, object, takes_forces, kind, troubles }
    }
}

impl Source for Lender {
    fn open(&self) -> Result<Box<dyn Instance>, OutsideError> {
        let name = &self.contract.name;
        let made = Python::attach(|py| {
            self.object.call_method0(py, "open").map_err(|error| {
                let (what, message) = ("a new simulator", error.to_string());
                self.troubles.raise(what.to_owned(), error);
                let (simulator, what) = (name.clone(), what.to_owned());
                OutsideError::Raised { simulator, what, message }
            })
        })?;
        let troubles = Arc::clone(&self.troubles);
        let mut instance = PythonInstance::new(&self.contract, made, self.takes_forces, troubles);
        if matches!(self.kind, Lending::Remote(_)) {
            return Ok(Box::new(RemoteInstance::new(instance)));
        }
        instance.is_stacked = matches!(self.kind, Lending::Stacked(_));
        let steps = Python::attach(|py| {
            let steps = instance.object.bind(py).getattr("steps").ok()?;
            steps.cast_into::<SceneSteps>().ok().map(Bound::unbind)
        });
        Ok(match steps {
            Some(steps) => Box::new(SceneInstance { python: instance, steps }),
            None => Box::new(instance),
        })
    }

    fn lanes(&self) -> usize {
        match self.kind {
            Lending::Single => 1,
            Lending::Stacked(lanes) | Lending::Remote(lanes) => lanes,
        }
    }

    fn takes_equations(&self) -> bool {
        matches!(self.kind, Lending::Remote(_))
    }
}

impl Troubles {
    /// Ends all work at the next call.
    pub(crate) fn stop(&self) {
        self.stopped.store(true, Relaxed);
    }

    pub(crate) fn is_stopped(&self) -> bool {
        self.stopped.load(Relaxed)
    }

    /// An exception that is the end; the first one counts.
    pub(crate) fn raise(&self, what: String, error: PyErr) {
        open(&self.raised).get_or_insert((what, error));
        self.stop();
    }

    /// The exception that was the end, and what was asked.
    pub(crate) fn take(&self) -> Option<(String, PyErr)> {
        open(&self.raised).take()
    }

    /// Something that may be why a study fails; the first one counts.
    pub(crate) fn note(&self, text: impl FnOnce() -> String) {
        open(&self.note).get_or_insert_with(text);
    }

    /// The first thing that may be why.
    pub(crate) fn noted(&self) -> Option<String> {
        open(&self.note).clone()
    }
}

/// Whether an exception means that there are no numbers here: an `ArithmeticError`, `fdiag.Diverged` among them.
pub(crate) fn is_divergence(py: Python<'_>, error: &PyErr) -> bool {
    error.is_instance_of::<PyArithmeticError>(py)
}
