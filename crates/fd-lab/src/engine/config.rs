//! Every choice of the engine benchmark, with the paper's experiment as the default.

use std::{path::Path, str::FromStr};

use fd_compensate::{
    decide::{Debouncing, Sizing},
    detect::DEFAULT_MARGIN,
};
use fd_core::{LimitError, Limits, Resource};
use fd_ident::arx::ArxOrders;
use fd_jetengine::{Perturbation, engine17::Unmodelled};
use fd_model::{
    file::{SettingsError, read_settings, write_settings},
    uncertainty::MatrixPerturbation,
};
use fdiag::spec::{
    ApplySpec, BiasSpec, DetectorSpec, GeneratorSpec, LearningSpec, OrderSpec, PipelineSpec,
    check_limits,
};
use serde::{Deserialize, Serialize};

use super::{
    excitation::{FreshRun, TrainingRun},
    on_line::OnLineConfig,
};

/// The version of the configuration format.
pub const CONFIG_VERSION: u32 = 1;

/// The benchmark: plants, model, diagnosis, runs and faults.
///
/// All signals are per unit of the operating point: fuel 0.1 is 10 % more fuel, residual 0.01 is
/// 1 % of the reading.
///
/// ```
/// let config = fd_lab::engine::EngineConfig::default();
/// assert_eq!(config.to_toml()?.parse::<fd_lab::engine::EngineConfig>()?, config);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EngineConfig {
    /// Version of this format.
    pub version: u32,
    /// Number of perturbed plants.
    pub seeds: u64,
    /// Seed of the first one.
    pub first_seed: u64,
    /// Time between samples in s.
    pub sample_time_s: f64,
    /// The plant and what makes it differ from its model.
    pub plant: PlantConfig,
    /// How the model of the residual generator is made from the nominal plant.
    pub reduction: ReductionConfig,
    /// The run that the bias is learned from.
    pub training: TrainingRun,
    /// Fault-free runs that thresholds and results are taken from, all with fresh inputs.
    pub fresh: FreshRun,
    /// Number of fresh runs that set the thresholds.
    pub calibration_runs: usize,
    /// Number of fresh runs that the results are taken from.
    pub test_runs: usize,
    /// Incipient sensor faults.
    pub faults: FaultConfig,
    /// The diagnosis.
    pub pipeline: PipelineSpec,
    /// The same with the bias learned on line.
    pub on_line: OnLineConfig,
}

/// The plant and what makes it differ from its model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PlantConfig {
    /// Which engine.
    pub engine: EngineChoice,
    /// What is drawn anew for each seed; by default each entry of `A` and `B` changes by up to
    /// 10 %, while the sensors read true. For the nonlinear engine the *model* is changed instead:
    /// the engine is what it is.
    pub perturbation: Perturbation,
    /// Standard deviation of the white sensor noise, relative to the reading.
    pub noise: f64,
}

/// Which engine stands for reality.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum EngineChoice {
    /// The 17-state turbofan, linearised at an operating point, as in the paper.
    Engine17 {
        /// Fuel flow of the operating point in kg/s: 0.12 is idle, 0.95 is high.
        #[serde(default = "reference_fuel")]
        fuel_kg_s: f64,
    },
    /// The 17-state turbofan itself, nonlinear.
    Engine17Nonlinear {
        /// Fuel flow of the operating point in kg/s at which the model is made.
        #[serde(default = "reference_fuel")]
        fuel_kg_s: f64,
        /// Fuel flow at which the test runs take place, if the operating point moves after the bias
        /// was learned and the thresholds were set.
        #[serde(default)]
        moved_to_kg_s: Option<f64>,
        /// Largest relative deviation of module efficiencies and flow capacities, uniform.
        #[serde(default = "health_scatter")]
        health_scatter: f64,
        /// Fuel actuator, hot metal and sensor lags that no model knows; none leaves them out.
        #[serde(default)]
        unmodelled: Option<Unmodelled>,
    },
    /// The published 16-state model of the F100.
    F100 {},
    /// The published 3-state model of Chen, Patton & Zhang (1996).
    ChenPattonZhang {},
}

fn reference_fuel() -> f64 {
    0.712
}

fn health_scatter() -> f64 {
    0.02
}

/// How the model of the residual generator is made from the nominal plant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum ReductionConfig {
    /// Keeps the states that are measured and takes the others in steady state: exact steady
    /// state, states with a meaning.
    MeasuredStates {},
    /// Balanced truncation: small error at all frequencies, but a standing bias.
    BalancedTruncation {
        /// Number of states.
        order: usize,
    },
    /// Balanced residualisation: exact steady state.
    BalancedResidualisation {
        /// Number of states.
        order: usize,
    },
    /// The full model.
    None {},
}

/// Incipient sensor faults: a ramp that rises and then stays.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FaultConfig {
    /// Outputs by name.
    pub sensors: Vec<String>,
    /// Start in s from the beginning of a fresh run.
    pub start_s: f64,
    /// Rise time in s.
    pub rise_s: f64,
    /// Size relative to the reading, for the pictures and the detection delay.
    pub size: f64,
}

impl Default for EngineConfig {
    fn default() -> Self {
        Self {
            version: CONFIG_VERSION,
            seeds: 1000,
            first_seed: 1,
            sample_time_s: 0.05,
            plant: PlantConfig::default(),
            reduction: ReductionConfig::MeasuredStates {},
            training: TrainingRun::default(),
            fresh: FreshRun::default(),
            calibration_runs: 20,
            test_runs: 10,
            faults: FaultConfig::default(),
            pipeline: default_pipeline(),
            on_line: OnLineConfig::default(),
        }
    }
}

impl Default for PlantConfig {
    fn default() -> Self {
        Self {
            engine: EngineChoice::Engine17 { fuel_kg_s: reference_fuel() },
            perturbation: Perturbation::Matrices(MatrixPerturbation {
                matrices: [true, true, false, false],
                ..MatrixPerturbation::default()
            }),
            noise: 5e-4,
        }
    }
}

impl Default for FaultConfig {
    fn default() -> Self {
        let sensors = vec!["T_7".to_owned(), "P_6".to_owned()];
        Self { sensors, start_s: 10.0, rise_s: 10.0, size: 0.005 }
    }
}

fn default_pipeline() -> PipelineSpec {
    PipelineSpec {
        generator: GeneratorSpec::Observer { rate: 2.0 },
        weighting: Some(vec![vec![1.0; 5]]),
        bias: BiasSpec {
            orders: OrderSpec::Fixed(ArxOrders::paper(2)),
            learning: LearningSpec::Batch { prefilter_rad_s: Some(8.0) },
            apply: ApplySpec::Always,
            ..BiasSpec::default()
        },
        // Every run starts from rest, so there is nothing to forget.
        settle_s: Some(0.0),
        detector: DetectorSpec::Maximum { margin: DEFAULT_MARGIN },
        rule: Debouncing::default(),
        // Two seconds: long against the noise, short against the rise of the fault.
        sizing: Sizing { memory: Some(40.0), ..Sizing::default() },
        ..PipelineSpec::default()
    }
}

impl FromStr for EngineConfig {
    type Err = toml::de::Error;

    /// From TOML, compiled once: `toml::from_str` is compiled again wherever it is used.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        toml::from_str(text)
    }
}

impl EngineConfig {
    /// Reads a file.
    ///
    /// # Errors
    ///
    /// A file that is missing or wrong; a wrong one with line and key.
    pub fn read(file: &Path) -> Result<Self, SettingsError> {
        read_settings(file)
    }

    /// The configuration as TOML, compiled once: `toml::to_string` is compiled again wherever it is used.
    ///
    /// # Errors
    ///
    /// None for a configuration that was read.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        write_settings(self)
    }

    /// Compares the size of the benchmark and the numbers of its spec with limits.
    ///
    /// ```
    /// use fd_core::Limits;
    /// use fd_lab::engine::EngineConfig;
    ///
    /// let config = EngineConfig { seeds: u64::MAX, ..EngineConfig::default() };
    /// let refused = config.check_limits(&Limits::default()).map_err(|error| error.to_string());
    /// let words = "seeds: expected at most 100000 (limit `cases`), found 1.8446744073709552e19";
    /// assert_eq!(refused, Err(words.to_owned()));
    /// ```
    ///
    /// # Errors
    ///
    /// Returns the first setting that is beyond its limit.
    pub fn check_limits(&self, limits: &Limits) -> Result<(), LimitError> {
        check_limits(self, limits)?;
        for (what, duration) in [
            ("training.duration_s / sample_time_s", self.training.duration_s),
            ("fresh.duration_s / sample_time_s", self.fresh.duration_s),
            ("on_line.longest_s / sample_time_s", self.on_line.longest_s),
            ("on_line.after_s / sample_time_s", self.on_line.after_s),
        ] {
            limits.check(Resource::Samples, what, duration / self.sample_time_s)?;
        }
        Ok(())
    }
}
