//! One seed looked at closely: the signals behind the paper's figures 4 to 7.

use fd_model::Record;
use fdiag::training::{Trace, Trained, TrainingError, residual_record};
use serde::{Deserialize, Serialize};

use super::{
    benchmark::{Benchmark, Case},
    error::EngineStudyError,
};

/// Frequencies at which gains are compared.
const FREQUENCIES: usize = 200;

/// Signals of one fresh run of one seed, healthy and with each incipient fault.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Example {
    /// Seed.
    pub seed: u64,
    /// Time in s.
    pub time: Vec<f64>,
    /// Input, first channel, per unit.
    pub input: Vec<f64>,
    /// Threshold of the primary and of the compensated residual; one per unit of the statistic.
    pub thresholds: (f64, f64),
    /// Healthy run.
    pub healthy: Residuals,
    /// One entry per faulty sensor.
    pub faulty: Vec<FaultyRun>,
    /// Training: time, residual and what the frozen model makes of the input.
    pub training: TrainingTrace,
    /// Gain from the first input to the first residual over frequency in rad/s: what the bias is
    /// (for a linear plant), and what was learned.
    pub gains: Vec<(f64, f64, f64)>,
}

/// A residual before and after compensation, first channel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Residuals {
    /// Primary.
    pub primary: Vec<f64>,
    /// Compensated.
    pub compensated: Vec<f64>,
}

/// A run with one incipient sensor fault.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FaultyRun {
    /// Name of the sensor.
    pub sensor: String,
    /// Unit of its reading.
    pub unit: String,
    /// Change of the reading from the operating point, with the fault.
    pub reading: Vec<f64>,
    /// The fault in it.
    pub fault: Vec<f64>,
    /// Residuals.
    pub residuals: Residuals,
    /// Time of the first alarm in s, without and with compensation.
    pub alarms: (Option<f64>, Option<f64>),
}

/// The training run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrainingTrace {
    /// Time in s.
    pub time: Vec<f64>,
    /// Residual.
    pub residual: Vec<f64>,
    /// Simulated bias.
    pub bias: Vec<f64>,
}

impl Benchmark {
    /// Runs one seed and keeps its signals.
    ///
    /// # Errors
    ///
    /// As [`Benchmark::trial`].
    pub fn example(&self, seed: u64) -> Result<Example, EngineStudyError> {
        let mut case = self.case(seed)?;
        let logs = self.logs(&mut case)?;
        let training = logs.training;
        let trained = Self::train(&self.config().pipeline, &case, &training, &logs.calibration)?;
        let Some(record) = logs.tests.into_iter().next() else {
            return Err(EngineStudyError::None { setting: "test_runs" });
        };
        let run = |record: &Record| -> Result<(Trace, Trace), EngineStudyError> {
            let with =
                Trace::of(&mut trained.compensated()?, record).map_err(TrainingError::from)?;
            let without =
                Trace::of(&mut trained.uncompensated()?, record).map_err(TrainingError::from)?;
            Ok((without, with))
        };
        let (without, with) = run(&record)?;
        let thresholds = (first(&without.threshold), first(&with.threshold));
        let profile = self.fault_profile();
        let mut faulty = Vec::new();
        for channel in self.fault_channels()? {
            let (name, scale) = &self.readings()[channel];
            let size = self.config().faults.size;
            let mut broken = record.clone();
            for (k, share) in profile.iter().enumerate() {
                broken.y_mut(k)[channel] += size * share;
            }
            let (without, with) = run(&broken)?;
            let at = |trace: &Trace| trace.first_alarm(0).map(|k| trace.time[k]);
            faulty.push(FaultyRun {
                sensor: name.name.clone(),
                unit: name.unit.clone(),
                reading: broken.output(channel).map(|v| v * scale).collect(),
                fault: profile.iter().map(|share| size * share * scale).collect(),
                alarms: (at(&without), at(&with)),
                residuals: residuals(&with),
            });
        }
        Ok(Example {
            seed,
            time: with.time.clone(),
            input: record.input(0).collect(),
            thresholds,
            healthy: residuals(&with),
            faulty,
            training: training_trace(&trained, &training)?,
            gains: self.gains(&trained, &case)?,
        })
    }
}

impl Benchmark {
    fn gains(
        &self,
        trained: &Trained,
        case: &Case,
    ) -> Result<Vec<(f64, f64, f64)>, EngineStudyError> {
        let model = trained.bias_model();
        let Some(plant) = &case.plant else { return Ok(Vec::new()) };
        if model.frequency_response(0, 0, 1.0).is_none() {
            // A nonlinear bias has no gain to compare.
            return Ok(Vec::new());
        }
        let form = trained.design().form().map_err(TrainingError::from)?;
        let bias = form.residual_of(plant).map_err(TrainingError::from)?;
        let (low, high) = (0.05_f64, std::f64::consts::PI / self.ts().seconds());
        (0..FREQUENCIES)
            .map(|i| {
                let omega = low * (high / low).powf(i as f64 / (FREQUENCIES - 1) as f64);
                let truth = bias.frequency_response(omega)?[(0, 0)].norm();
                Ok((
                    omega,
                    truth,
                    model.frequency_response(0, 0, omega).map_or(f64::NAN, faer::c64::norm),
                ))
            })
            .collect()
    }
}

fn training_trace(trained: &Trained, run: &Record) -> Result<TrainingTrace, EngineStudyError> {
    let mut generator = trained.design().build().map_err(TrainingError::from)?;
    let residual = residual_record(&mut generator, run, 0)?;
    let model = trained.bias_model();
    let bias = model.simulate_record(&residual).map_err(TrainingError::from)?;
    let channels = residual.outputs().len();
    Ok(TrainingTrace {
        time: (0..run.len()).map(|k| run.time(k)).collect(),
        residual: residual.output(0).collect(),
        bias: bias.into_iter().step_by(channels).collect(),
    })
}

fn residuals(trace: &Trace) -> Residuals {
    let channel = |values: &[f64]| values.iter().step_by(trace.channels.max(1)).copied().collect();
    Residuals { primary: channel(&trace.residual), compensated: channel(&trace.compensated) }
}

fn first(values: &[f64]) -> f64 {
    values.first().copied().unwrap_or(f64::NAN)
}
