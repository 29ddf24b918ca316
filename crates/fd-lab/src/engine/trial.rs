//! One perturbed engine from training to the smallest faults that are found.

use fd_core::{
    Event,
    stage::{Detector, Stage},
};
use fd_model::{Channel, Record};
use fd_numeric::median;
use fdiag::{
    spec::PipelineSpec,
    training::{Trace, Trained, TrainingError, sensor_sizes, train_on},
};
use serde::{Deserialize, Serialize};

use super::{
    benchmark::{Benchmark, Case},
    error::EngineStudyError,
    on_line::OnLine,
    pair::Pair,
    watch::{Run, Watch},
};

/// What came out for one seed. Residuals and fault sizes are per unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// Seed of the perturbation, the inputs and the noise.
    pub seed: u64,
    /// Unstable draws of the perturbation that were drawn again.
    pub redraws: usize,
    /// Orders of the bias model.
    pub orders: String,
    /// Frozen parameters.
    pub theta: Vec<f64>,
    /// Sample at which a recursive training froze them.
    pub frozen_at: Option<u64>,
    /// Largest fault-free residual over the calibration runs.
    pub fault_free: Pair,
    /// Largest fault-free residual over the test runs.
    pub fault_free_test: Pair,
    /// Share of fault-free test runs with an alarm, without and with compensation.
    pub false_alarms: Pair,
    /// One entry per faulty sensor.
    pub faults: Vec<FaultOutcome>,
    /// What came out when the bias was learned on line, if that was asked for.
    #[serde(default)]
    pub on_line: Option<OnLine>,
}

/// What came out for one faulty sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FaultOutcome {
    /// Name of the sensor.
    pub sensor: String,
    /// Steady residual, largest channel, for a fault of size 1.
    pub residual_gain: f64,
    /// Median smallest detectable size over test runs and both signs, relative to the reading;
    /// infinite when most runs cannot show it at all.
    pub smallest: Pair,
    /// The same for the best constant threshold on the whole residual vector: on the combination of its
    /// channels that shows this sensor best next to the healthy runs. NaN when a channel of the vector
    /// could not be learned.
    #[serde(default)]
    pub smallest_of_vector: Pair,
    /// Share of test runs in which the fault of the configured size is found.
    pub found: Pair,
    /// Median estimate of the size of that fault at the end of the run, relative to its true size,
    /// from the compensated residual and taken as known which sensor it is; NaN when it is never
    /// found.
    pub estimated: f64,
    /// Median delay from the start of the fault to the alarm in s, over the runs in which it is
    /// found; NaN when it never is.
    pub delay_s: Pair,
}

/// Residuals of the test runs and what is needed to judge them.
pub(super) struct Tests {
    pub start: usize,
    pub primary: Vec<Run>,
    pub compensated: Vec<Run>,
}

impl Benchmark {
    /// Runs one seed.
    ///
    /// # Errors
    ///
    /// Returns what stopped it; training can fail on unlucky data.
    pub fn trial(&self, seed: u64) -> Result<Trial, EngineStudyError> {
        let mut case = self.case(seed)?;
        let logs = self.logs(&mut case)?;
        let trained =
            Self::train(&self.config().pipeline, &case, &logs.training, &logs.calibration)?;
        let tests = self.tests(&trained, &logs.tests)?;
        let vector = self.best_thresholds(&case, &logs)?;
        let (primary, compensated) = trained.calibration();
        let mut plain = Watch::new(&trained, primary)?;
        let mut compensated = Watch::new(&trained, compensated)?;
        let false_alarms = Pair {
            primary: plain.false_alarms(&tests.primary)?,
            compensated: compensated.false_alarms(&tests.compensated)?,
        };
        let mut faults = Vec::new();
        for (channel, smallest_of_vector) in self.fault_channels()?.into_iter().zip(vector) {
            let (phi, phi_star) = self.unit_fault_response(&trained, channel)?;
            let size = self.config().faults.size;
            let a = plain.find(&tests.primary, &phi, size, tests.start)?;
            let b = compensated.find(&tests.compensated, &phi_star, size, tests.start)?;
            let last = phi.len() - trained.design().residual_len();
            let seconds = |samples: f64| samples * self.ts().seconds();
            faults.push(FaultOutcome {
                sensor: self.readings()[channel].0.name.clone(),
                residual_gain: phi[last..].iter().fold(0.0, |m, v| v.abs().max(m)),
                smallest: Pair { primary: a.smallest, compensated: b.smallest },
                smallest_of_vector,
                estimated: self.estimated_size(&trained, &tests.compensated, &phi_star, channel)?,
                found: Pair { primary: a.share, compensated: b.share },
                delay_s: Pair { primary: seconds(a.delay), compensated: seconds(b.delay) },
            });
        }
        let (primary, compensated) = trained.fault_free_maxima();
        Ok(Trial {
            seed,
            redraws: case.redraws,
            orders: trained.bias_model().orders(),
            theta: trained.bias_model().theta(),
            frozen_at: trained.events().last().map(|event: &Event| event.k),
            fault_free: Pair { primary, compensated },
            fault_free_test: Pair {
                primary: largest(&tests.primary),
                compensated: largest(&tests.compensated),
            },
            false_alarms,
            faults,
            on_line: self.on_line(&mut case, &logs)?,
        })
    }

    /// Learns from one run and calibrates on others.
    pub(super) fn train(
        spec: &PipelineSpec,
        case: &Case,
        training: &Record,
        calibration: &[Record],
    ) -> Result<Trained, EngineStudyError> {
        Ok(train_on(spec, case.plant(), training, calibration)?)
    }

    pub(super) fn tests(
        &self,
        trained: &Trained,
        records: &[Record],
    ) -> Result<Tests, EngineStudyError> {
        let mut tests = Tests {
            start: self.samples(self.config().faults.start_s),
            primary: Vec::new(),
            compensated: Vec::new(),
        };
        // Calibrating the detector is the dear part of a pipeline, so one serves all runs.
        let mut pipeline = trained.compensated()?;
        for record in records {
            pipeline.reset();
            let trace = Trace::of(&mut pipeline, record).map_err(TrainingError::from)?;
            let inputs: Vec<f64> = record.samples().flat_map(|(u, _)| u.iter().copied()).collect();
            tests.primary.push(Run { inputs: inputs.clone(), residual: trace.residual });
            tests.compensated.push(Run { inputs, residual: trace.compensated });
        }
        Ok(tests)
    }

    /// What an incipient fault of size 1 adds to both residuals. The generator and the compensation
    /// are linear in `y`, so the difference between a plant at rest with and without the fault is
    /// what it adds to any run. Without one-step compensation the two are the same.
    pub(super) fn unit_fault_response(
        &self,
        trained: &Trained,
        channel: usize,
    ) -> Result<(Vec<f64>, Vec<f64>), EngineStudyError> {
        let size = self.config().faults.size.max(f64::MIN_POSITIVE);
        let io = trained.design().io();
        let profile = self.fault_profile();
        let at_rest = |size: f64| -> Result<Trace, EngineStudyError> {
            let u = vec![0.0; profile.len() * io.nu];
            let y = profile
                .iter()
                .flat_map(|v| (0..io.ny).map(move |i| if i == channel { size * v } else { 0.0 }))
                .collect();
            let record =
                Record::new(Channel::numbered("u", io.nu), self.outputs(), u, y, self.ts())?;
            // Nobody judges, so that no threshold has to be found.
            Ok(Trace::of(&mut trained.silent()?, &record).map_err(TrainingError::from)?)
        };
        let (faulty, healthy) = (at_rest(size)?, at_rest(0.0)?);
        let per_unit = |faulty: &[f64], healthy: &[f64]| {
            faulty.iter().zip(healthy).map(|(f, h)| (f - h) / size).collect()
        };
        Ok((
            per_unit(&faulty.residual, &healthy.residual),
            per_unit(&faulty.compensated, &healthy.compensated),
        ))
    }

    /// Estimated over true size of the configured fault.
    fn estimated_size(
        &self,
        trained: &Trained,
        runs: &[Run],
        phi: &[f64],
        channel: usize,
    ) -> Result<f64, EngineStudyError> {
        let size = self.config().faults.size;
        let (nu, channels) = (trained.design().io().nu, trained.design().residual_len());
        let mut detector = trained.detector(trained.calibration().1)?;
        let mut ratios = Vec::new();
        for Run { inputs, residual } in runs {
            detector.reset();
            let mut trace = Trace { channels, ..Trace::default() };
            trace.compensated = residual.iter().zip(phi).map(|(r, g)| r + size * g).collect();
            let rows = trace.compensated.chunks_exact(channels);
            for (u, row) in inputs.chunks_exact(nu).zip(rows) {
                let verdict = detector.update(u, row);
                trace.statistic.push(verdict.statistic);
                trace.threshold.push(verdict.threshold);
                trace.compensating.push(true);
            }
            if let Some(sizes) = sensor_sizes(trained, &trace)? {
                ratios.push(sizes[channel] / size);
            }
        }
        Ok(median(&mut ratios))
    }

    /// The incipient fault of size 1 over a fresh run.
    pub(super) fn fault_profile(&self) -> Vec<f64> {
        let faults = &self.config().faults;
        (0..self.samples(self.config().fresh.duration_s))
            .map(|k| {
                let since = k as f64 * self.ts().seconds() - faults.start_s;
                (since / faults.rise_s.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0)
            })
            .collect()
    }

    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a sample index")]
    pub(super) fn samples(&self, seconds: f64) -> usize {
        (seconds / self.ts().seconds()).round().max(0.0) as usize
    }
}

fn largest(runs: &[Run]) -> f64 {
    runs.iter().flat_map(|run| &run.residual).fold(0.0, |m, v| v.abs().max(m))
}
