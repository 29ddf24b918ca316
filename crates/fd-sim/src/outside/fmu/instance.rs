//! One instance of an FMU, run after run.

use std::sync::{Arc, atomic::Ordering::Relaxed};

#[cfg(unix)]
use super::{
    super::process::{tell, tell_in_case_of_an_end},
    loaded::{ENDS, LEAVES},
};
use super::{
    super::{
        error::OutsideError,
        source::{Instance, Lost, Start},
    },
    api::{Component, Failure},
    described::References,
    fault::fault,
    loaded::Loaded,
};

/// After so many runs a new instance is made: some leak at every reset.
const RUNS: u32 = 500;

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

fn values(bits: &[u64]) -> Vec<f64> {
    bits.iter().map(|bits| f64::from_bits(*bits)).collect()
}

/// An instance of an FMU.
#[derive(Debug)]
pub(super) struct FmuInstance {
    loaded: Arc<Loaded>,
    /// None when the next run needs a new one.
    component: Option<Component>,
    /// Runs of this component.
    runs: u32,
    /// Whether its first run has made a step, and whether a reset was seen to undo that.
    has_stepped: bool,
    is_proven: bool,
    /// What this component showed at the beginning of its first run.
    fresh: Option<Beginning>,
    /// Number of the next step.
    step: u64,
}

impl FmuInstance {
    pub(super) fn open(loaded: &Arc<Loaded>) -> Result<Self, OutsideError> {
        let component = loaded.component().map_err(|found| {
            let file = &loaded.described.file;
            fault(file, "its function to instantiate", "an instance", &found)
        })?;
        Ok(Self {
            loaded: Arc::clone(loaded),
            component: Some(component),
            runs: 0,
            has_stepped: false,
            is_proven: false,
            fresh: None,
            step: 0,
        })
    }

    fn lost(&self, failure: Failure) -> Lost {
        match failure {
            Failure::Run(_) => Lost::Refused,
            Failure::Fatal(found) => {
                let file = &self.loaded.described.file;
                Lost::Broken(Box::new(fault(file, "a call", "success", &found)))
            }
        }
    }

    fn ts(&self) -> f64 {
        self.loaded.described.contract.ts.seconds()
    }

    fn with(
        &mut self,
        act: impl FnOnce(&mut Component, &References) -> Result<(), Failure>,
    ) -> Result<(), Lost> {
        let missing = || Failure::Fatal("no instance".to_owned());
        let component = self.component.as_mut().ok_or_else(missing);
        let done =
            component.and_then(|component| act(component, &self.loaded.described.references));
        done.map_err(|failure| self.lost(failure))
    }

    /// From an instance that is fresh, or reset, to the first sample.
    fn begin(&mut self, start: Start<'_>) -> Result<(), Lost> {
        let ts = self.ts();
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
        let fresh = self.loaded.component();
        self.component = Some(fresh.map_err(|found| self.lost(Failure::Fatal(found)))?);
        (self.runs, self.fresh) = (0, None);
        (self.has_stepped, self.is_proven) = (false, false);
        Ok(())
    }

    /// The beginning of a run; what cannot be read is not seen.
    fn beginning(&mut self, start: Start<'_>) -> Beginning {
        let loaded = Arc::clone(&self.loaded);
        let mut seen = vec![0.0; loaded.visible.len()];
        if self.with(|component, _| component.get(&loaded.visible, &mut seen)).is_err() {
            seen.clear();
        }
        let (theta, x0) = (bits(start.theta), bits(start.x0));
        Beginning { theta, x0, first: start.first, seen: bits(&seen) }
    }

    /// Whether it is to be reset, and was not seen to survive that.
    #[cfg(unix)]
    fn is_in_doubt(&self) -> bool {
        !self.is_proven && !self.loaded.keeps_runs.load(Relaxed)
    }

    /// Resets it, unless that is no way to begin again: some leak at every reset, some cannot be reset, and some say that
    /// they are and are not. That is found out once, by the beginning of the first run: later ones may all be others.
    fn is_reset(&mut self) -> bool {
        let may_reset = self.runs < RUNS && !self.loaded.keeps_runs.load(Relaxed);
        if !may_reset || self.with(|component, _| component.reset()).is_err() {
            return false;
        }
        let Some(fresh) = self.fresh.clone().filter(|_| self.has_stepped && !self.is_proven) else {
            return true;
        };
        let (theta, x0) = (values(&fresh.theta), values(&fresh.x0));
        let start = Start { theta: &theta, x0: &x0, first: fresh.first };
        if self.begin(start).is_err() {
            return false;
        }
        self.is_proven = true;
        if self.is_left_over(start) {
            self.keeps_runs();
            return false;
        }
        self.with(|component, _| component.reset()).is_ok()
    }

    /// From now on it is not reset any more.
    fn keeps_runs(&self) {
        self.loaded.keeps_runs.store(true, Relaxed);
        #[cfg(unix)]
        if self.loaded.is_alone {
            tell(LEAVES);
        }
    }

    /// From a run to the first sample of the next one.
    fn begin_again(&mut self, start: Start<'_>) -> Result<(), Lost> {
        self.step = start.first;
        if 0 < self.runs && !self.is_reset() {
            self.renew()?;
        }
        self.begin(start)?;
        if self.runs == 1 {
            self.fresh = Some(self.beginning(start));
        } else if self.is_left_over(start) {
            self.keeps_runs();
            self.renew()?;
            self.begin(start)?;
        }
        Ok(())
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
        #[cfg(unix)]
        if self.loaded.is_alone && 0 < self.runs && self.is_in_doubt() {
            tell_in_case_of_an_end(ENDS);
            let begun = self.begin_again(start);
            tell_in_case_of_an_end("");
            return begun;
        }
        self.begin_again(start)
    }

    fn measure(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Lost> {
        self.with(|component, references| {
            component.set(&references.inputs, u)?;
            component.get(&references.outputs, y)
        })
    }

    fn step(&mut self, row: &[f64], y: &mut [f64], x: &mut [f64]) -> Result<(), Lost> {
        self.has_stepped = true;
        let (time, ts) = (self.step as f64 * self.ts(), self.ts());
        self.step += 1;
        self.with(|component, references| {
            component.set(&references.inputs, row)?;
            component.get(&references.outputs, y)?;
            component.step(time, ts)?;
            component.get(&references.states, x)
        })
    }
}
