//! One instance of an FMU, run after run.

use std::sync::Arc;

use super::{
    super::{
        error::OutsideError,
        source::{Instance, Lost, Start},
    },
    Fmu, Unpacked,
    api::{Component, Failure},
};

/// After so many runs a new instance is made: some leak at every reset.
const RUNS: u32 = 500;

/// References of the variables of a contract, in its order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct References {
    /// Inputs, then ports.
    pub(super) inputs: Vec<u32>,
    pub(super) outputs: Vec<u32>,
    pub(super) parameters: Vec<u32>,
    pub(super) states: Vec<u32>,
}

/// An instance of an FMU.
#[derive(Debug)]
pub(super) struct FmuInstance {
    unpacked: Arc<Unpacked>,
    references: Arc<References>,
    file: String,
    ts: f64,
    /// None when the next run needs a new one.
    component: Option<Component>,
    /// Runs of this component.
    runs: u32,
    /// Number of the next step.
    step: u64,
}

impl FmuInstance {
    pub(super) fn open(fmu: &Fmu) -> Result<Self, OutsideError> {
        let unpacked = Arc::clone(&fmu.unpacked);
        let component = unpacked
            .component()
            .map_err(|found| fmu.wrong("its function to instantiate", "an instance", &found))?;
        Ok(Self {
            unpacked,
            references: Arc::clone(&fmu.references),
            file: fmu.file.clone(),
            ts: fmu.contract.ts.seconds(),
            component: Some(component),
            runs: 0,
            step: 0,
        })
    }

    fn lost(&self, failure: Failure) -> Lost {
        match failure {
            Failure::Run(_) => Lost::Refused,
            Failure::Fatal(found) => Lost::Broken(Box::new(OutsideError::Fmu {
                file: self.file.clone(),
                what: "a call".to_owned(),
                expected: "success".to_owned(),
                found,
            })),
        }
    }

    fn with(
        &mut self,
        act: impl FnOnce(&mut Component, &References) -> Result<(), Failure>,
    ) -> Result<(), Lost> {
        let missing = || Failure::Fatal("no instance".to_owned());
        let component = self.component.as_mut().ok_or_else(missing);
        let done = component.and_then(|component| act(component, &self.references));
        done.map_err(|failure| self.lost(failure))
    }

    /// From an instance that is fresh, or reset, to the first sample.
    fn begin(
        component: &mut Component,
        references: &References,
        start: Start<'_>,
        ts: f64,
    ) -> Result<(), Failure> {
        component.set(&references.parameters, start.theta)?;
        component.set(&references.states, start.x0)?;
        component.initialise(start.first as f64 * ts)
    }
}

impl Instance for FmuInstance {
    fn reset(&mut self, start: Start<'_>) -> Result<(), Lost> {
        let ts = self.ts;
        let is_reset = self.runs == 0
            || (self.runs < RUNS && self.with(|component, _| component.reset()).is_ok());
        if !is_reset {
            // Those that cannot be reset are made anew; the old one has to be gone before.
            self.component = None;
            let fresh = self.unpacked.component();
            self.component = Some(fresh.map_err(|found| self.lost(Failure::Fatal(found)))?);
            self.runs = 0;
        }
        self.runs += 1;
        self.step = start.first;
        self.with(|component, references| Self::begin(component, references, start, ts))
    }

    fn measure(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Lost> {
        self.with(|component, references| {
            component.set(&references.inputs, u)?;
            component.get(&references.outputs, y)
        })
    }

    fn step(&mut self, row: &[f64], y: &mut [f64], x: &mut [f64]) -> Result<(), Lost> {
        let (time, ts) = (self.step as f64 * self.ts, self.ts);
        self.step += 1;
        self.with(|component, references| {
            component.set(&references.inputs, row)?;
            component.get(&references.outputs, y)?;
            component.step(time, ts)?;
            component.get(&references.states, x)
        })
    }
}
