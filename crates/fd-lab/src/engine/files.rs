//! One seed as a user would have it: a model file, a spec, healthy logs and one with an incipient fault, in physical units.

use fd_model::{
    Channel, ChannelScale, Record, Scaling,
    file::{LinearModel, LinearSystem},
};
use fdiag::spec::PipelineSpec;

use super::{
    benchmark::{Benchmark, Case},
    config::EngineChoice,
    error::EngineStudyError,
};

/// What `fdiag compensate` needs to repeat one seed of the benchmark.
#[derive(Clone, Debug)]
pub struct UserFiles {
    /// The nominal model, with operating point and scales.
    pub model: LinearModel,
    /// The methods of the benchmark.
    pub spec: PipelineSpec,
    /// The run that the bias is learned from, then runs that the threshold is taken from.
    pub healthy: Vec<Record>,
    /// A fresh run with the fault of the first sensor of the configuration.
    pub faulty: Record,
}

impl Benchmark {
    /// The files of one seed, with at most `calibration_runs` runs for the threshold.
    ///
    /// # Errors
    ///
    /// As [`Benchmark::trial`]; without a faulty sensor or a test run; a model that no file can hold.
    pub fn user_files(
        &self,
        seed: u64,
        calibration_runs: usize,
    ) -> Result<UserFiles, EngineStudyError> {
        let mut case = self.case(seed)?;
        let logs = self.logs(&mut case)?;
        let none = |setting| EngineStudyError::None { setting };
        let channel = *self.fault_channels()?.first().ok_or_else(|| none("sensors"))?;
        let mut faulty = logs.tests.into_iter().next().ok_or_else(|| none("test_runs"))?;
        for (k, share) in self.fault_profile().iter().enumerate() {
            faulty.y_mut(k)[channel] += self.config().faults.size * share;
        }
        let outputs: Vec<Channel> = self.readings().iter().map(|(name, _)| name.clone()).collect();
        let (inputs, scaling) = self.physical(&case);
        let system = LinearSystem::Discrete(case.model.clone());
        let mut model = LinearModel::new(system, inputs.clone(), outputs.clone())?;
        model.name = Some(format!("{}, nominal", self.engine_name()));
        let channels = model.inputs.iter_mut().chain(&mut model.outputs);
        for (channel, scale) in channels.zip(scaling.inputs.iter().chain(&scaling.outputs)) {
            channel.scale = *scale;
        }
        let physical = |record: &Record| record.unscaled(&scaling, &inputs, &outputs);
        let calibration = logs.calibration.iter().take(calibration_runs);
        let healthy = std::iter::once(&logs.training).chain(calibration).map(physical);
        Ok(UserFiles {
            model,
            spec: self.config().pipeline.clone(),
            healthy: healthy.collect::<Result<_, _>>()?,
            faulty: physical(&faulty)?,
        })
    }

    /// Inputs in physical units, and what makes physical signals those of the model: deviations from the operating point
    /// of the turbofan in its units, signals of the published linear engines in theirs.
    fn physical(&self, case: &Case) -> (Vec<Channel>, Scaling) {
        let readings = self.readings().iter().map(|(_, reading)| *reading);
        let per_unit = |value| ChannelScale::per_unit(value, value);
        match &self.config().plant.engine {
            EngineChoice::Engine17 { fuel_kg_s }
            | EngineChoice::Engine17Nonlinear { fuel_kg_s, .. } => {
                let unit = |input: &Channel| Channel::new(input.name.clone(), "kg/s");
                let inputs = self.inputs().iter().map(unit).collect();
                let scaling = case.scaling.clone().unwrap_or_else(|| Scaling {
                    inputs: vec![per_unit(*fuel_kg_s)],
                    outputs: readings.map(per_unit).collect(),
                });
                (inputs, scaling)
            }
            EngineChoice::F100 {} | EngineChoice::ChenPattonZhang {} => {
                let outputs =
                    readings.map(|reading| ChannelScale::per_unit(0.0, reading)).collect();
                let inputs = vec![ChannelScale::default(); self.inputs().len()];
                (self.inputs().to_vec(), Scaling { inputs, outputs })
            }
        }
    }
}
