//! An object of Python that lends runs.

use std::sync::Arc;

use fd_sim::outside::{Contract, Instance, OutsideError, Source};
use pyo3::prelude::*;

use crate::{
    instance::PythonInstance,
    remote::RemoteInstance,
    scene::{SceneInstance, SceneSteps},
    troubles::Troubles,
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
