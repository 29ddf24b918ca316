//! The logs of a case, as they are and as they are read.

use fd_model::{Channel, Record, SampleTime};

use super::{
    controller::reference_name,
    error::BlindError,
    simulate::Trace,
    truth::{Scene, rows},
};

/// A log with what its reader may not know.
pub(super) struct LogOfRun {
    /// The log.
    pub record: Record,
    /// The reference of the controller that is not in the model.
    pub reference: Option<(Channel, Vec<f64>)>,
    /// Whether each row is in the file.
    pub is_kept: Vec<bool>,
    /// States of the plant at its first sample, and how far each moves.
    pub start: Vec<f64>,
    pub spread: Vec<f64>,
}

/// Which part of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// What is logged first.
    First,
    /// What goes on after that, of a run that is cut.
    Second,
}

impl Scene<'_> {
    /// The log of a run as it is in truth; `None` when it diverges. Without noise it is what could
    /// be known at best: exact values with the commands that the plant really had, noise in them
    /// and all; what is missing is missing.
    pub(super) fn log(&self, run: u64, is_noisy: bool) -> Result<Option<Record>, BlindError> {
        Ok(self.log_of(run, Part::First, is_noisy)?.map(|log| log.record))
    }

    /// A part of a run.
    pub(super) fn log_of(
        &self,
        run: u64,
        part: Part,
        is_noisy: bool,
    ) -> Result<Option<LogOfRun>, BlindError> {
        let (truth, x0) = (self.truth, self.initial(run));
        // In an unknown loop noise moves the plant, and the log shows what it was moved by.
        let conditions = &truth.conditions;
        let is_moved = is_noisy || conditions.controller.is_some();
        let trace = self.trace(&truth.effects, &truth.parameters, &x0, run, is_moved)?;
        let Some(trace) = trace else { return Ok(None) };
        let whole = self.whole(run, &trace, is_noisy)?;
        let samples = truth.samples;
        let from = conditions.before + if part == Part::Second { samples } else { 0 };
        let nx = trace.states.len() / rows(truth);
        let state = |k: usize| &trace.states[k * nx..(k + 1) * nx];
        let plant_states = nx.min(self.model.states.len());
        let spread = |i: usize| {
            let values: Vec<f64> = (from..from + samples).map(|k| state(k)[i]).collect();
            let mean = values.iter().sum::<f64>() / samples as f64;
            (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / samples as f64).sqrt()
        };
        let zero = self.model.sample_time * conditions.before as f64;
        let cut = |log: &Record| {
            let cut = log.slice(from, from + samples);
            let start = cut.time(0) - zero;
            cut.starting_at(start).as_its_own_run()
        };
        let reference = conditions.controller.as_ref().map(|controller| {
            let channel = Channel::new(
                reference_name(self.model, controller),
                &self.model.outputs[controller.output].unit,
            );
            let (u, nu) = (self.excitation(run), self.plant.drives.len());
            let values = (from..from + samples).map(|k| u[k * nu + controller.input]);
            (channel, values.collect())
        });
        Ok(Some(LogOfRun {
            record: cut(&whole.0),
            reference,
            is_kept: whole.1.get(from..from + samples).map_or_else(Vec::new, <[bool]>::to_vec),
            // The states of a plant at rest are those of its model; in motion, only of most.
            start: if from == 0 { x0 } else { state(from)[..plant_states].to_vec() },
            spread: (0..plant_states).map(spread).collect(),
        }))
    }

    /// The whole run through the logger and the reader; whether each row is kept.
    fn whole(
        &self,
        run: u64,
        trace: &Trace,
        is_noisy: bool,
    ) -> Result<(Record, Vec<bool>), BlindError> {
        let (conditions, ny) = (&self.truth.conditions, self.model.outputs.len());
        let mut u = self.excitation(run);
        if conditions.controller.is_some() {
            u.clone_from(&trace.commands);
        }
        let mut y = if is_noisy { trace.y.clone() } else { trace.clean.clone() };
        let stretch = conditions.stretch();
        let n = rows(self.truth) / stretch;
        if 1 < stretch {
            let nu = u.len() / (n * stretch);
            let every = |values: &[f64], width: usize| -> Vec<f64> {
                values.chunks_exact(width).step_by(stretch).flatten().copied().collect()
            };
            (u, y) = (every(&u, nu), every(&y, ny));
        }
        let mut is_kept = vec![true; n];
        if let Some(logger) = &conditions.logger {
            let logged = logger.log(&y, &u, ny, run, is_noisy);
            (y, is_kept) = (logged.y, logged.is_kept);
        }
        let (inputs, outputs) = (self.model.external_inputs(), self.model.output_channels());
        let ts = SampleTime::new(self.model.sample_time)?;
        let record = Record::new(inputs, outputs, u, y, ts)?;
        let read = match &conditions.misreading {
            Some(misreading) => misreading.read(&record)?,
            None => record,
        };
        Ok((read, is_kept))
    }

    /// Standard deviation of the noise of each output, with what the logger adds to it.
    pub(super) fn sigma(&self) -> Vec<f64> {
        let outputs = self.model.outputs.iter().enumerate();
        let of = |(c, output): (usize, &fd_sim::model::Output)| {
            let sensor = output.noise.unwrap_or(1.0);
            let logger = self.truth.conditions.logger.as_ref();
            logger.map_or(sensor, |l| sensor.hypot(l.noise(c, self.scales.outputs[c].slope)))
        };
        outputs.map(of).collect()
    }
}
