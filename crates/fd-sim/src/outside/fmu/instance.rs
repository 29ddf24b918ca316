//! One instance of an FMU, run after run.

use std::sync::{Arc, atomic::Ordering::Relaxed};

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

/// Where a run begins, and the bits of what can be seen there.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Beginning {
    theta: Vec<u64>,
    x0: Vec<u64>,
    first: u64,
    seen: Vec<u64>,
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
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
    /// What this component showed at the beginning of its first run.
    fresh: Option<Beginning>,
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
            fresh: None,
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
    fn begin(&mut self, start: Start<'_>) -> Result<(), Lost> {
        let ts = self.ts;
        self.runs += 1;
        self.with(|component, references| {
            component.set(&references.parameters, start.theta)?;
            component.set(&references.states, start.x0)?;
            component.initialise(start.first as f64 * ts)
        })
    }

    /// Makes another instance; the old one has to be gone before.
    fn renew(&mut self) -> Result<(), Lost> {
        self.component = None;
        let fresh = self.unpacked.component();
        self.component = Some(fresh.map_err(|found| self.lost(Failure::Fatal(found)))?);
        (self.runs, self.fresh) = (0, None);
        Ok(())
    }

    /// The beginning of a run; what cannot be read is not seen.
    fn beginning(&mut self, start: Start<'_>) -> Beginning {
        let unpacked = Arc::clone(&self.unpacked);
        let mut seen = vec![0.0; unpacked.visible.len()];
        if self.with(|component, _| component.get(&unpacked.visible, &mut seen)).is_err() {
            seen.clear();
        }
        let (theta, x0) = (bits(start.theta), bits(start.x0));
        Beginning { theta, x0, first: start.first, seen: bits(&seen) }
    }

    /// Whether a run that was begun by a reset begins otherwise than the same run in a fresh instance.
    fn is_left_over(&mut self, start: Start<'_>) -> bool {
        let now = self.beginning(start);
        let same = |fresh: &&Beginning| {
            (&fresh.theta, &fresh.x0, fresh.first) == (&now.theta, &now.x0, now.first)
        };
        self.fresh.as_ref().filter(same).is_some_and(|fresh| fresh.seen != now.seen)
    }
}

impl Instance for FmuInstance {
    fn reset(&mut self, start: Start<'_>) -> Result<(), Lost> {
        self.step = start.first;
        // Some leak at every reset, some cannot be reset, and some say that they are and are not.
        let may_reset = self.runs < RUNS && !self.unpacked.keeps_runs.load(Relaxed);
        if 0 < self.runs && !(may_reset && self.with(|component, _| component.reset()).is_ok()) {
            self.renew()?;
        }
        self.begin(start)?;
        if self.runs == 1 {
            self.fresh = Some(self.beginning(start));
        } else if self.is_left_over(start) {
            self.unpacked.keeps_runs.store(true, Relaxed);
            self.renew()?;
            self.begin(start)?;
        }
        Ok(())
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
