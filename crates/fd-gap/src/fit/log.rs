//! A record, in the order and the units of a simulator.

use std::ops::Range;

use fd_model::{Channel, Circle, Record};
use fd_sim::simulate::Simulator;

use super::error::FitError;

/// Relative difference of two sample times that are meant to be equal.
const ROUNDING: f64 = 1e-6;

/// Samples of the channels of a simulator, row by row. Holes in inputs are filled with the last
/// value (what that leaves unknown of the outputs is for a fit to leave out); missing outputs are NaN.
#[derive(Clone, Debug, PartialEq)]
pub struct Log {
    pub(crate) u: Vec<f64>,
    pub(crate) y: Vec<f64>,
    pub(crate) nu: usize,
    pub(crate) ny: usize,
    pub(crate) samples: usize,
    /// Number of the first sample since the clock of the model was started.
    pub(crate) first: usize,
    /// Whether it goes on where another one ended, so that its clock does.
    pub(crate) goes_on: bool,
    /// Whether the log begins in motion: its states are not where the model says they start.
    pub(crate) is_in_motion: bool,
    /// Number of the first sample in all logs that are fitted, one after the other; `None` for others.
    pub(crate) row: Option<usize>,
    /// Rows in which an input was missing.
    pub(crate) holes: Vec<Range<usize>>,
    /// Samples at which a simulation begins anew, with states that nobody knows.
    pub(crate) restarts: Vec<usize>,
    /// Samples of the run before, at its front: simulated, and compared with nothing.
    pub(crate) lead: usize,
    /// Where the values of each output live.
    pub(crate) circles: Vec<Circle>,
}

impl Log {
    /// Picks the channels of a simulator out of a record, by name, and converts their units; a unit
    /// that nobody knows is fine when both write it alike. `number`, from 1, names the record in
    /// errors.
    ///
    /// ```
    /// use fd_gap::fit::Log;
    /// use fd_sim::simulate::BlackBox;
    /// use faer::mat;
    /// use fd_model::{Channel, Discrete, Record, SampleTime, StateSpace};
    ///
    /// let ts = SampleTime::new(0.1)?;
    /// let lag = StateSpace::new(mat![[0.5]], mat![[0.5]], mat![[1.0]], mat![[0.0]], Discrete { ts })?;
    /// let (volt, metre) = (vec![Channel::new("u", "V")], vec![Channel::new("y", "m")]);
    /// let simulator = BlackBox::discrete(&lag, volt, metre)?;
    /// let (mv, mm) = (vec![Channel::new("u", "mV")], vec![Channel::new("y", "mm")]);
    /// let record = Record::new(mv, mm, vec![1000.0; 5], vec![2.0; 5], ts)?;
    /// assert_eq!(Log::new(&record, &simulator, 1)?.samples(), 5);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when the sample times differ, a channel is missing, its unit does not fit,
    /// or an input has no value at all.
    ///
    /// A [slice](Record::slice) of a run begins in motion, and keeps the clock of that.
    pub fn new(
        record: &Record,
        simulator: &dyn Simulator,
        number: usize,
    ) -> Result<Self, FitError> {
        let (expected, found) = (simulator.ts().seconds(), record.ts().seconds());
        if ROUNDING * expected < (expected - found).abs() {
            return Err(FitError::SampleTime { log: number, expected, found });
        }
        let places =
            |role, wanted: &[Channel], known: &[Channel]| -> Result<Vec<usize>, FitError> {
                let place = |channel: &Channel| known.iter().position(|k| k.name == channel.name);
                let missing = |channel: &Channel| FitError::Channel {
                    log: number,
                    role,
                    channel: channel.name.clone(),
                    known: known.iter().map(|known| known.name.clone()).collect(),
                };
                wanted.iter().map(|c| place(c).ok_or_else(|| missing(c))).collect()
            };
        let inputs = places("input", simulator.inputs(), record.inputs())?;
        let outputs = places("output", simulator.outputs(), record.outputs())?;
        // Only channels that the simulator has are converted, and only where the units differ.
        let units = |known: &[Channel], wanted: &[Channel], places: &[usize]| -> Vec<String> {
            let mut units: Vec<String> = known.iter().map(|channel| channel.unit.clone()).collect();
            places.iter().zip(wanted).for_each(|(&i, w)| units[i].clone_from(&w.unit));
            units
        };
        let input_units = units(record.inputs(), simulator.inputs(), &inputs);
        let output_units = units(record.outputs(), simulator.outputs(), &outputs);
        let input_units: Vec<&str> = input_units.iter().map(String::as_str).collect();
        let output_units: Vec<&str> = output_units.iter().map(String::as_str).collect();
        let first = record.samples_before();
        let record = &record
            .in_units(&input_units, &output_units)
            .map_err(|source| FitError::Unit { log: number, source })?;
        let y = (0..record.len()).flat_map(|k| outputs.iter().map(move |&i| record.y(k)[i]));
        let mut u: Vec<f64> =
            (0..record.len()).flat_map(|k| inputs.iter().map(move |&i| record.u(k)[i])).collect();
        let holes = Self::holes(&u, inputs.len());
        for (i, channel) in simulator.inputs().iter().enumerate() {
            let empty = || FitError::EmptyInput { log: number, channel: channel.name.clone() };
            let column = u.iter().skip(i).step_by(inputs.len());
            let mut last = column.copied().find(|v| v.is_finite()).ok_or_else(empty)?;
            for value in u.iter_mut().skip(i).step_by(inputs.len()) {
                if value.is_finite() {
                    last = *value;
                }
                *value = last;
            }
        }
        let (nu, ny) = (inputs.len(), outputs.len());
        let (mut y, mut circles): (Vec<f64>, Vec<Circle>) = (y.collect(), Vec::with_capacity(ny));
        for (c, channel) in simulator.outputs().iter().enumerate() {
            circles.push(channel.circle());
            let mut last = f64::NAN;
            for value in y.iter_mut().skip(c).step_by(ny) {
                *value = circles[c].go_on(*value, &mut last);
            }
        }
        Ok(Self {
            u,
            y,
            nu,
            ny,
            samples: record.len(),
            first,
            goes_on: 0 < first,
            is_in_motion: 0 < first,
            row: None,
            holes,
            restarts: Vec::new(),
            lead: 0,
            circles,
        })
    }

    /// The logs of records, each [`continuing`](Self::continuing) one of the `earlier` ones if it
    /// does.
    pub(crate) fn all(
        records: &[Record],
        simulator: &dyn Simulator,
        earlier: &[Record],
    ) -> Result<Vec<Self>, FitError> {
        let mut next = 0;
        let each = records.iter().enumerate().map(|(i, record)| {
            let row = Some(next);
            next += record.len();
            let log = Self::new(record, simulator, i + 1)?
                .without_still_outputs()
                .without_unknown_outputs(simulator);
            Ok(Self { row, ..log.continuing(record, earlier, simulator)? })
        });
        each.collect()
    }

    /// The logs of held-out records: they begin in motion where the `fitted` ones do.
    pub(crate) fn held_out(
        records: &[Record],
        simulator: &dyn Simulator,
        earlier: &[Record],
        fitted: &[Self],
    ) -> Result<Vec<Self>, FitError> {
        let mut logs = Self::all(records, simulator, earlier)?;
        // A stretch of a run is in motion whatever its run began with.
        let is_in_motion = fitted.iter().any(|log| log.is_in_motion && log.first == 0);
        for log in &mut logs {
            log.is_in_motion |= is_in_motion && log.lead == 0;
            log.row = None;
        }
        Ok(logs)
    }

    /// The log of `record` if that goes on where one of the `earlier` ones ended: a periodic force keeps its phase, a
    /// drift goes on, and the states are wherever that run had brought them. They are free, or, where the `simulator`
    /// shows none, found by simulating that run first. Any other log is another run and begins where the model says; on the
    /// clock of the first that it [comes after](Record::comes_after), or on its own.
    ///
    /// # Errors
    ///
    /// As [`Log::new`], for the earlier record.
    pub fn continuing(
        mut self,
        record: &Record,
        earlier: &[Record],
        simulator: &dyn Simulator,
    ) -> Result<Self, FitError> {
        let before = (1..).zip(earlier).find(|(_, before)| record.continues(before));
        let Some((number, before)) = before else {
            let before = earlier.iter().filter(|before| record.comes_after(before));
            let origin = before.min_by(|a, b| a.time(0).total_cmp(&b.time(0)));
            self.first = origin.map_or(self.first, |origin| record.samples_since(origin));
            return Ok(self);
        };
        if simulator.initial().is_empty() {
            return Ok(self.behind(Self::new(before, simulator, number)?));
        }
        self.first = record.samples_since(before);
        self.goes_on = true;
        self.is_in_motion = true;
        Ok(self)
    }

    /// The log with the inputs of the one before at its front.
    fn behind(mut self, before: Self) -> Self {
        let lead = before.samples;
        let moved = self.holes.iter().map(|hole| hole.start + lead..hole.end + lead);
        let (holes, restarts) = (moved.collect(), self.restarts.iter().map(|k| k + lead).collect());
        let Self { mut u, first, goes_on, is_in_motion, .. } = before;
        u.append(&mut self.u);
        let mut y = vec![f64::NAN; lead * self.ny];
        y.append(&mut self.y);
        let samples = lead + self.samples;
        Self { u, y, samples, first, goes_on, is_in_motion, holes, restarts, lead, ..self }
    }

    /// The same log without outputs that stand still beside others that move: what a sensor in coarse steps, or a
    /// broken one, has not shown is no measurement of the plant.
    fn without_still_outputs(mut self) -> Self {
        let moves = |c: usize| {
            let mut values = self.y.iter().skip(c).step_by(self.ny).filter(|v| v.is_finite());
            let first = values.next();
            values.any(|value| Some(value) != first)
        };
        let moving: Vec<bool> = (0..self.ny).map(moves).collect();
        if moving.contains(&true) {
            for (c, _) in moving.iter().enumerate().filter(|(_, moves)| !**moves) {
                self.y.iter_mut().skip(c).step_by(self.ny).for_each(|value| *value = f64::NAN);
            }
        }
        self
    }

    /// The same log, whose states at the start nobody knows.
    #[must_use]
    pub fn in_motion(self) -> Self {
        Self { is_in_motion: true, ..self }
    }

    /// The same log, begun so many samples after the clock of its effects.
    pub(crate) fn begun_at(self, first: usize) -> Self {
        Self { first, ..self }
    }

    /// Whether it is a run of its own: it goes on from none of the other logs.
    pub(crate) fn is_own_run(&self) -> bool {
        !self.goes_on && self.lead == 0
    }

    /// Samples of the run before at its front, which are simulated and compared with nothing.
    #[must_use]
    pub fn lead(&self) -> usize {
        self.lead
    }

    /// Number of samples.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// The first `samples` samples.
    pub(crate) fn prefix(&self, samples: usize) -> Self {
        let samples = samples.min(self.samples);
        let (u, y) = (self.u[..samples * self.nu].to_vec(), self.y[..samples * self.ny].to_vec());
        let restarts = self.restarts.iter().copied().filter(|k| *k < samples).collect();
        let circles = self.circles.clone();
        Self { u, y, samples, holes: Vec::new(), restarts, circles, ..*self }
    }

    /// Number of the first sample since the clock of the model was started.
    #[must_use]
    pub fn first(&self) -> usize {
        self.first
    }

    /// Inputs of a sample, in the order and the units of the simulator; the last one is held.
    #[must_use]
    pub fn input(&self, sample: usize) -> &[f64] {
        let sample = sample.min(self.samples - 1);
        &self.u[sample * self.nu..(sample + 1) * self.nu]
    }

    /// Inputs with the number of the sample in all fitted logs, row by row, as a stand-in wants them.
    pub(crate) fn with_rows(&self) -> Vec<f64> {
        self.rows(0..self.samples).collect()
    }

    /// The same of some samples.
    pub(crate) fn rows(&self, samples: Range<usize>) -> impl Iterator<Item = f64> {
        let begin = self.row.unwrap_or_default();
        samples.flat_map(move |k| self.input(k).iter().copied().chain([(begin + k) as f64]))
    }

    /// Measured outputs of a sample, in the order and the units of the simulator; NaN where there
    /// is none.
    ///
    /// # Panics
    ///
    /// Panics when there is no such sample.
    #[must_use]
    pub fn output(&self, sample: usize) -> &[f64] {
        &self.y[sample * self.ny..(sample + 1) * self.ny]
    }

    /// Number of measured values.
    pub(crate) fn measured(&self) -> usize {
        self.y.iter().filter(|value| value.is_finite()).count()
    }
}
