//! The requests that an outside simulator has to answer.

use std::fmt::Debug;

use super::error::OutsideError;
use crate::simulate::{Around, Run};

/// Where a run begins.
#[derive(Clone, Copy, Debug)]
pub struct Start<'a> {
    /// Parameters, in the order of the contract.
    pub theta: &'a [f64],
    /// Initial states, in the order of the contract.
    pub x0: &'a [f64],
    /// Number of the first step since the clock of the model was started.
    pub first: u64,
}

/// Why a run was lost.
#[derive(Clone, Debug, PartialEq)]
pub enum Lost {
    /// The simulator says that it cannot go on from here: a divergence.
    Refused,
    /// It has ended or is silent. Another one may do it.
    Gone(Box<OutsideError>),
    /// It does not keep to the contract. Another one would not either.
    Broken(Box<OutsideError>),
}

/// One of several runs that are asked for at once.
#[derive(Debug)]
pub struct Lane<'a> {
    /// Where it begins.
    pub start: Start<'a>,
    /// Inputs and forces, row by row.
    pub rows: &'a [f64],
    /// Outputs, row by row, to be written.
    pub y: &'a mut [f64],
}

/// One running simulator. Rows are inputs and then forces of a sample; `x` has the states of the contract, or
/// no entry where they cannot be seen.
pub trait Instance: Debug + Send {
    /// Begins a run.
    ///
    /// # Errors
    ///
    /// Returns why the run is lost.
    fn reset(&mut self, start: Start<'_>) -> Result<(), Lost>;

    /// Writes the outputs of this sample without moving on.
    ///
    /// # Errors
    ///
    /// Returns why the run is lost.
    fn measure(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Lost>;

    /// Writes the outputs of this sample and moves on; writes the states then.
    ///
    /// # Errors
    ///
    /// Returns why the run is lost.
    fn step(&mut self, row: &[f64], y: &mut [f64], x: &mut [f64]) -> Result<(), Lost>;

    /// A whole run of so many samples, with the bits of its steps. It is left at the end of the run.
    ///
    /// # Errors
    ///
    /// Returns why the run is lost; outputs that are not finite are no error.
    fn rollout(
        &mut self,
        start: Start<'_>,
        rows: &[f64],
        samples: usize,
        y: &mut [f64],
        x: &mut [f64],
    ) -> Result<(), Lost> {
        by_steps(self, start, rows, samples, y, x)
    }

    /// Begins a run in each of several lanes, which then step together; only as many as the contract says.
    ///
    /// # Errors
    ///
    /// Returns why all of them are lost; one that cannot begin gives outputs that are not finite.
    fn reset_lanes(&mut self, starts: &[Start<'_>]) -> Result<(), Lost> {
        match starts {
            [start] => self.reset(*start),
            _ => Err(Lost::Refused),
        }
    }

    /// Writes the outputs of this sample of all lanes, one after the other, without moving on.
    ///
    /// # Errors
    ///
    /// Returns why all of them are lost.
    fn measure_lanes(&mut self, lanes: usize, u: &[f64], y: &mut [f64]) -> Result<(), Lost> {
        if lanes == 1 { self.measure(u, y) } else { Err(Lost::Refused) }
    }

    /// Writes the outputs of this sample of all lanes and moves on, then the states: rows, outputs and states of one
    /// lane after those of the other. A lane that diverges gives outputs that are not finite, and is stepped on.
    ///
    /// # Errors
    ///
    /// Returns why all of them are lost.
    fn step_lanes(
        &mut self,
        lanes: usize,
        rows: &[f64],
        y: &mut [f64],
        x: &mut [f64],
    ) -> Result<(), Lost> {
        if lanes == 1 { self.step(rows, y, x) } else { Err(Lost::Refused) }
    }

    /// Whole runs of this simulator in equations of a shell, through the same inputs `u`, of a source that
    /// [takes them](Source::takes_equations). `around` is that of the first run.
    ///
    /// # Errors
    ///
    /// Returns why all of them are lost; outputs that are not finite are no error.
    fn in_equations(&mut self, _around: Around<'_>, _runs: &mut [Run<'_>]) -> Result<(), Lost> {
        Err(Lost::Refused)
    }

    /// Whole runs of so many samples each; of a simulator that shows no states, and only as many as its source says.
    ///
    /// # Errors
    ///
    /// Returns why all of them are lost.
    fn rollouts(&mut self, samples: usize, lanes: &mut [Lane<'_>]) -> Result<(), Lost> {
        lanes
            .iter_mut()
            .try_for_each(|lane| self.rollout(lane.start, lane.rows, samples, lane.y, &mut []))
    }
}

/// A whole run, step by step; after a divergence the rest is NaN.
///
/// # Errors
///
/// Returns why the run is lost.
pub fn by_steps<I: Instance + ?Sized>(
    instance: &mut I,
    start: Start<'_>,
    rows: &[f64],
    samples: usize,
    y: &mut [f64],
    x: &mut [f64],
) -> Result<(), Lost> {
    instance.reset(start)?;
    let (width, ny) = (rows.len() / samples.max(1), y.len() / samples.max(1));
    for k in 0..samples {
        let outputs = &mut y[k * ny..(k + 1) * ny];
        let is_finite = match instance.step(&rows[k * width..(k + 1) * width], outputs, x) {
            Ok(()) => outputs.iter().all(|value| value.is_finite()),
            Err(Lost::Refused) => false,
            Err(lost) => return Err(lost),
        };
        if !is_finite {
            y[k * ny..].fill(f64::NAN);
            break;
        }
    }
    Ok(())
}

/// Whole runs of so many samples each, step by step in lanes beside each other; after a divergence the rest is NaN.
///
/// # Errors
///
/// Returns why all of them are lost.
pub fn by_lanes<I: Instance + ?Sized>(
    instance: &mut I,
    samples: usize,
    lanes: &mut [Lane<'_>],
) -> Result<(), Lost> {
    let starts: Vec<Start<'_>> = lanes.iter().map(|lane| lane.start).collect();
    instance.reset_lanes(&starts)?;
    let of = |all: usize| all / samples.max(1);
    let width = lanes.first().map_or(0, |lane| of(lane.rows.len()));
    let ny = lanes.first().map_or(0, |lane| of(lane.y.len()));
    let mut y = vec![0.0; lanes.len() * ny];
    for k in 0..samples {
        let rows: Vec<f64> =
            lanes.iter().flat_map(|l| &l.rows[k * width..(k + 1) * width]).copied().collect();
        instance.step_lanes(lanes.len(), &rows, &mut y, &mut [])?;
        for (lane, y) in lanes.iter_mut().zip(y.chunks_exact(ny.max(1))) {
            lane.y[k * ny..(k + 1) * ny].copy_from_slice(y);
        }
    }
    for lane in lanes {
        if let Some(from) = lane.y.iter().position(|value| !value.is_finite()) {
            lane.y[from / ny * ny..].fill(f64::NAN);
        }
    }
    Ok(())
}

/// What starts simulators.
pub trait Source: Debug + Send + Sync {
    /// Starts one.
    ///
    /// # Errors
    ///
    /// Returns why that is not possible.
    fn open(&self) -> Result<Box<dyn Instance>, OutsideError>;

    /// What was found out about the simulator while it ran, and its user should know.
    fn note(&self) -> Option<String> {
        None
    }

    /// Whether each of them begins every run afresh by itself, also where the contract says that it cannot be reset.
    fn renews(&self) -> bool {
        false
    }

    /// How many whole runs one of them takes in one call.
    fn lanes(&self) -> usize {
        1
    }

    /// Whether they make whole runs in equations of a shell: worth it where asking takes longer than the equations.
    fn takes_equations(&self) -> bool {
        false
    }
}
