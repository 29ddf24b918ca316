//! One engine, watched by every residual.

use std::time::Instant;

use fd_model::Record;
use fdiag::spec::{DeviationSpec, GeneratorSpec, ModelSource, PipelineSpec};

use super::{
    diagnose::{engine_text, name},
    exact::as_if_linear,
    scenario::{JoinedScenario, SCATTER},
};
use crate::engine::{Benchmark, EngineChoice, EngineStudyError, logs::Logs};

/// Time in s of the training run that is diagnosed.
const DIAGNOSED_S: f64 = 20.0;
/// Noise that drives each state of a filter, relative, per root of a second.
const PROCESS_NOISE: f64 = 1e-3;

/// Samples over which the extended filter renews its slopes: half a second.
const LINEARISED_OVER: u32 = 10;

/// Rate of the observers in 1/s, that of the benchmark.
const OBSERVER_RATE: f64 = 2.0;

/// Which residual watches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Residual {
    /// The observer of the linear model.
    Linear,
    /// The stationary Kalman filter of the linear model.
    Kalman,
    /// The extended Kalman filter of the nominal nonlinear engine.
    Extended,
    /// The unscented one.
    Unscented,
    /// Measured minus simulated output of the nominal nonlinear engine.
    Nominal,
    /// The same with the named cause in it.
    Patched,
    /// What the nominal simulation leaves, seen by the linear observer.
    ObservedNominal,
    /// What the patched simulation leaves, seen by the linear observer.
    ObservedPatched,
    /// What the engine itself would leave as a model, seen by the linear observer: the noise of the sensors, and no
    /// model could leave less.
    ObservedExact,
}

impl Residual {
    /// All of them, the opponent first.
    pub const ALL: [Self; 9] = [
        Self::Linear,
        Self::Kalman,
        Self::Extended,
        Self::Unscented,
        Self::Nominal,
        Self::Patched,
        Self::ObservedNominal,
        Self::ObservedPatched,
        Self::ObservedExact,
    ];

    /// Those that run the engine once per sample at most, and not once per slope or sigma point.
    pub const QUICK: [Self; 7] = [
        Self::Linear,
        Self::Kalman,
        Self::Nominal,
        Self::Patched,
        Self::ObservedNominal,
        Self::ObservedPatched,
        Self::ObservedExact,
    ];

    /// Its name in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear observer",
            Self::Kalman => "linear Kalman",
            Self::Extended => "extended",
            Self::Unscented => "unscented",
            Self::Nominal => "nonlinear simulation",
            Self::Patched => "patched simulation",
            Self::ObservedNominal => "nonlinear simulation, observed",
            Self::ObservedPatched => "patched simulation, observed",
            Self::ObservedExact => "the engine itself, observed",
        }
    }
}

/// Smallest faults of the watched sensors, in per unit of the reading.
#[derive(Clone, Debug, PartialEq)]
pub struct Smallest {
    /// Sensor, then without and with a bias model for what is left.
    pub sensors: Vec<(String, [f64; 2])>,
    /// Time of a sample in µs, on this machine.
    pub microseconds: f64,
}

/// What became of one engine.
#[derive(Clone, Debug)]
pub struct JoinedTrial {
    /// The engine.
    pub seed: u64,
    /// What the gap diagnosis named, or why it could not.
    pub named: String,
    /// Time in s that the diagnosis took.
    pub diagnosis_s: f64,
    /// Runs of the engine through the log that it made; NaN where it failed.
    pub diagnosis_runs: f64,
    /// One per residual of [`Residual::ALL`]; or why it could not watch, or was not asked.
    pub residuals: Vec<Result<Smallest, String>>,
}

impl JoinedScenario {
    /// Runs one engine, watched by the residuals that are `asked` for.
    ///
    /// # Errors
    ///
    /// Returns an error when the engine cannot be run at all.
    pub fn trial(&self, seed: u64, asked: &[Residual]) -> Result<JoinedTrial, EngineStudyError> {
        let benchmark = Benchmark::new(self.config.clone())?;
        let mut case = benchmark.case(seed)?;
        if let Some((parameter, shift)) = self.worn
            && let Some((learned, moved)) = benchmark.worn(&case, parameter, shift)?
        {
            (case.training, case.moved) = (learned, moved);
        }
        let draws = benchmark.draws(&mut case)?;
        let logs = benchmark.logs_of(&case, &draws)?;
        let scaling = case.plant().scaling();
        let EngineChoice::Engine17Nonlinear { fuel_kg_s, .. } = self.config.plant.engine else {
            return Err(EngineStudyError::None { setting: "nonlinear engine" });
        };
        let noise = self.config.plant.noise;
        let text = engine_text(fuel_kg_s, &scaling, noise, SCATTER);
        let begin = Instant::now();
        let beginning =
            |record: &Record| record.slice(0, benchmark.samples(DIAGNOSED_S).min(record.len()));
        let named = match logs.calibration.first() {
            Some(first) => name(&text, &beginning(&logs.training), &beginning(first), &scaling),
            None => Err("there is no calibration run".to_owned()),
        };
        let diagnosis_s = begin.elapsed().as_secs_f64();
        let residuals = Residual::ALL
            .into_iter()
            .map(|residual| {
                if !asked.contains(&residual) {
                    return Err("not asked".to_owned());
                }
                let generator = generator(residual, &text, &named, noise)?;
                let spec = PipelineSpec { generator, ..self.config.pipeline.clone() };
                let watched = |logs: &Logs| watched(&benchmark, &case, logs, &spec);
                let found = if residual == Residual::ObservedExact {
                    as_if_linear(&benchmark, &case, &draws, &logs).and_then(|logs| watched(&logs))
                } else {
                    watched(&logs)
                };
                found.map_err(|error| error.to_string())
            })
            .collect();
        let diagnosis_runs = named.as_ref().map_or(f64::NAN, |named| named.runs);
        let named = named.map_or_else(|error| format!("failed: {error}"), |named| named.words);
        Ok(JoinedTrial { seed, named, diagnosis_s, diagnosis_runs, residuals })
    }
}

/// The line of a spec.
fn generator(
    residual: Residual,
    text: &str,
    named: &Result<super::diagnose::Named, String>,
    noise: f64,
) -> Result<GeneratorSpec, String> {
    let model = ModelSource::Text { text: text.to_owned() };
    let process_noise = DeviationSpec::Relative(PROCESS_NOISE);
    let is_observed = matches!(residual, Residual::ObservedNominal | Residual::ObservedPatched);
    let simulated = |model| GeneratorSpec::Patched {
        model,
        track: std::collections::BTreeMap::new(),
        suspicion: 1.5,
        memory_s: 5.0,
        settle_s: 0.0,
        observer_rate: is_observed.then_some(OBSERVER_RATE),
    };
    Ok(match residual {
        Residual::Linear | Residual::ObservedExact => {
            GeneratorSpec::Observer { rate: OBSERVER_RATE }
        }
        Residual::Kalman => {
            // The same noises: a sample of 0.05 s takes this part of a second's variance.
            let process_noise = PROCESS_NOISE.powi(2) * 0.05;
            GeneratorSpec::Kalman { process_noise, output_noise: noise * noise }
        }
        Residual::Extended => GeneratorSpec::Extended {
            model,
            process_noise,
            output_noise: None,
            initial: None,
            linearised_over: LINEARISED_OVER,
        },
        Residual::Unscented => GeneratorSpec::Unscented {
            model,
            process_noise,
            output_noise: None,
            initial: None,
            kappa: None,
        },
        Residual::Nominal | Residual::ObservedNominal => simulated(model),
        Residual::Patched | Residual::ObservedPatched => match named {
            Ok(named) => simulated(ModelSource::Text { text: named.text.clone() }),
            Err(error) => return Err(error.clone()),
        },
    })
}

fn watched(
    benchmark: &Benchmark,
    case: &crate::engine::Case,
    logs: &Logs,
    spec: &PipelineSpec,
) -> Result<Smallest, EngineStudyError> {
    let trained = Benchmark::train(spec, case, &logs.training, &logs.calibration)?;
    let pairs = benchmark.best_thresholds_of(&trained, logs)?;
    let names = &benchmark.config().faults.sensors;
    let sensors = names.iter().cloned().zip(pairs.iter().map(|p| [p.primary, p.compensated]));
    Ok(Smallest { sensors: sensors.collect(), microseconds: cost(&trained, &logs.training)? })
}

/// Mean time of a sample of the generator alone.
fn cost(trained: &fdiag::training::Trained, record: &Record) -> Result<f64, EngineStudyError> {
    use fdiag::training::TrainingError;
    let mut generator = trained.design().build().map_err(TrainingError::from)?;
    let mut r = vec![0.0; generator.residual_len()];
    let begin = Instant::now();
    for (k, (u, y)) in (0..).zip(record.samples()) {
        let frame = fd_core::Frame::new(generator.io(), k, u, y).map_err(TrainingError::from)?;
        generator.step(frame, &mut r);
    }
    Ok(1e6 * begin.elapsed().as_secs_f64() / record.len() as f64)
}
