//! Simulators that make one run: another one is started for the next.

use std::sync::Arc;

use super::{
    error::OutsideError,
    source::{Instance, Lane, Lost, Source, Start},
    tally::Tally,
};
use crate::simulate::{Around, Run};

/// A source of simulators that cannot be reset.
#[derive(Debug)]
pub(super) struct Disposables {
    pub source: Arc<dyn Source>,
    pub tally: Arc<Tally>,
}

/// A simulator that begins each run in a new instance.
#[derive(Debug)]
struct Disposable {
    source: Arc<dyn Source>,
    tally: Arc<Tally>,
    instance: Option<Box<dyn Instance>>,
    is_used: bool,
}

impl Source for Disposables {
    fn open(&self) -> Result<Box<dyn Instance>, OutsideError> {
        let (source, tally) = (Arc::clone(&self.source), Arc::clone(&self.tally));
        let instance = Some(source.open()?);
        Ok(Box::new(Disposable { source, tally, instance, is_used: false }))
    }

    fn note(&self) -> Option<String> {
        self.source.note()
    }

    fn lanes(&self) -> usize {
        self.source.lanes()
    }

    fn takes_equations(&self) -> bool {
        self.source.takes_equations()
    }
}

impl Disposable {
    /// An instance that has made no run.
    fn unused(&mut self) -> Result<&mut dyn Instance, Lost> {
        if std::mem::replace(&mut self.is_used, true) {
            // The old one goes first: there may be a licence for one only.
            self.instance = None;
        }
        if self.instance.is_none() {
            let opened = self.source.open().map_err(|error| Lost::Gone(Box::new(error)))?;
            Tally::add(&self.tally.started, 1);
            self.instance = Some(opened);
        }
        Ok(&mut **self.instance.as_mut().ok_or(Lost::Refused)?)
    }

    /// The instance of the present run.
    fn present(&mut self) -> Result<&mut dyn Instance, Lost> {
        Ok(&mut **self.instance.as_mut().ok_or(Lost::Refused)?)
    }
}

impl Instance for Disposable {
    fn reset(&mut self, start: Start<'_>) -> Result<(), Lost> {
        self.unused()?.reset(start)
    }

    fn measure(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Lost> {
        self.present()?.measure(u, y)
    }

    fn step(&mut self, row: &[f64], y: &mut [f64], x: &mut [f64]) -> Result<(), Lost> {
        self.present()?.step(row, y, x)
    }

    fn rollout(
        &mut self,
        start: Start<'_>,
        rows: &[f64],
        samples: usize,
        y: &mut [f64],
        x: &mut [f64],
    ) -> Result<(), Lost> {
        self.unused()?.rollout(start, rows, samples, y, x)
    }

    fn reset_lanes(&mut self, starts: &[Start<'_>]) -> Result<(), Lost> {
        self.unused()?.reset_lanes(starts)
    }

    fn measure_lanes(&mut self, lanes: usize, u: &[f64], y: &mut [f64]) -> Result<(), Lost> {
        self.present()?.measure_lanes(lanes, u, y)
    }

    fn step_lanes(
        &mut self,
        lanes: usize,
        rows: &[f64],
        y: &mut [f64],
        x: &mut [f64],
    ) -> Result<(), Lost> {
        self.present()?.step_lanes(lanes, rows, y, x)
    }

    fn in_equations(&mut self, around: Around<'_>, runs: &mut [Run<'_>]) -> Result<(), Lost> {
        self.unused()?.in_equations(around, runs)
    }

    /// Runs that are asked for in one call begin together.
    fn rollouts(&mut self, samples: usize, lanes: &mut [Lane<'_>]) -> Result<(), Lost> {
        if self.source.lanes() <= 1 {
            return lanes.iter_mut().try_for_each(|lane| {
                self.rollout(lane.start, lane.rows, samples, lane.y, &mut [])
            });
        }
        self.unused()?.rollouts(samples, lanes)
    }
}
