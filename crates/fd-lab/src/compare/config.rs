//! Every choice of a comparison.

use std::{collections::BTreeSet, path::Path, str::FromStr};

use fd_compensate::decide::Debouncing;
use fd_core::Limits;
use fd_model::file::{SettingsError, read_settings, write_settings};
use fdiag::spec::{ApplySpec, BiasSpec, PipelineSpec, check_limits};
use serde::{Deserialize, Serialize};

use super::{
    defaults,
    error::CompareError,
    fault::FaultGrid,
    method::{Bias, Detector, Generator, is_diagnosed},
    scenario::Scenario,
};
use crate::engine::{EngineConfig, FreshRun, ReductionConfig, TrainingRun};

/// The version of the configuration format.
pub const CONFIG_VERSION: u32 = 1;

/// A tournament: every residual generator with every bias model and every detector, on every
/// scenario.
///
/// Engines that set the thresholds and engines that the results are taken from never mix. Each
/// engine is learned from a run of its own, its detectors are scaled on others, and what is counted
/// comes from still others.
///
/// ```
/// let config = fd_lab::compare::CompareConfig::default();
/// assert_eq!(config.to_toml()?.parse::<fd_lab::compare::CompareConfig>()?, config);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CompareConfig {
    /// Version of this format.
    pub version: u32,
    /// Seed of the first engine.
    pub first_seed: u64,
    /// How many engines and runs there are of each kind.
    pub engines: Engines,
    /// Wanted probability of an alarm in a fault-free run.
    pub false_alarms: f64,
    /// Time between samples in s.
    pub sample_time_s: f64,
    /// How the model of the residual generator is made from the nominal plant.
    pub reduction: ReductionConfig,
    /// The run that the bias is learned from.
    pub training: TrainingRun,
    /// All other runs, each with a fresh input.
    pub fresh: FreshRun,
    /// The faults that are to be found.
    pub faults: FaultGrid,
    /// Time in s at the start of each log that is not learned from, and of each run of an engine that no detector sees
    /// (up to where the faults begin).
    pub settle_s: Option<f64>,
    /// When an alarm is raised; the same for all entries.
    pub rule: Debouncing,
    /// What the methods are compared on.
    pub scenarios: Vec<Scenario>,
    /// Samples to residuals.
    pub generators: Vec<Generator>,
    /// Models of the bias that is subtracted.
    pub biases: Vec<Bias>,
    /// Residuals to alarms.
    pub detectors: Vec<Detector>,
}

/// How many engines and runs there are of each kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Engines {
    /// Engines that set the thresholds.
    pub thresholds: u64,
    /// Engines that the results are taken from.
    pub test: u64,
    /// Fault-free runs per engine, of any kind, that scale its detectors.
    pub calibration_runs: u64,
    /// Fault-free runs per engine that set the thresholds.
    pub threshold_runs: u64,
    /// Runs per test engine without an injected fault, in which no alarm may be.
    pub test_runs: u64,
    /// How many of these are also run with every fault in every size.
    pub fault_runs: u64,
}

impl Default for Engines {
    fn default() -> Self {
        Self {
            thresholds: 20,
            test: 20,
            calibration_runs: 10,
            threshold_runs: 20,
            test_runs: 15,
            fault_runs: 2,
        }
    }
}

impl Default for CompareConfig {
    fn default() -> Self {
        let engine = EngineConfig::default();
        Self {
            version: CONFIG_VERSION,
            first_seed: 1,
            engines: Engines::default(),
            false_alarms: 0.01,
            sample_time_s: engine.sample_time_s,
            reduction: engine.reduction,
            training: engine.training,
            fresh: engine.fresh,
            faults: FaultGrid::default(),
            settle_s: Some(0.0),
            rule: Debouncing::default(),
            scenarios: defaults::scenarios(),
            generators: defaults::generators(),
            biases: defaults::biases(),
            detectors: defaults::detectors(),
        }
    }
}

impl FromStr for CompareConfig {
    type Err = toml::de::Error;

    /// From TOML, compiled once: `toml::from_str` is compiled again wherever it is used.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        toml::from_str(text)
    }
}

impl CompareConfig {
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

    /// The benchmark behind a scenario.
    pub(super) fn engine(&self, scenario: &Scenario) -> EngineConfig {
        EngineConfig {
            sample_time_s: self.sample_time_s,
            plant: scenario.plant.clone(),
            reduction: self.reduction,
            training: self.training.clone(),
            fresh: self.fresh.clone(),
            ..EngineConfig::default()
        }
    }

    /// The pipeline of a generator and a bias model; the detector comes later.
    pub(super) fn pipeline(&self, generator: &Generator, bias: Option<&BiasSpec>) -> PipelineSpec {
        let nothing = || BiasSpec { apply: ApplySpec::Never, ..BiasSpec::default() };
        PipelineSpec {
            generator: generator.spec.clone(),
            weighting: generator.weighting.clone(),
            bias: bias.cloned().unwrap_or_else(nothing),
            rule: self.rule,
            settle_s: self.settle_s,
            ..PipelineSpec::default()
        }
    }

    /// Number of entries: every generator with every bias model and every detector.
    #[must_use]
    pub fn entries(&self) -> usize {
        self.generators.len() * self.biases.len() * self.detectors.len()
    }

    /// Rates of false alarms per run at which alarms are counted, the wanted one first, then those
    /// of the ROC that the fault-free runs can resolve.
    pub(super) fn rates(&self) -> Vec<f64> {
        let runs = self.engines.thresholds * self.engines.threshold_runs;
        let resolved = |rate: &f64| rate * (runs + 1) as f64 >= 1.0;
        let others = [0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5].into_iter().filter(resolved);
        let wanted = self.false_alarms;
        let differs = |rate: &f64| (rate - wanted).abs() > 1e-9;
        std::iter::once(wanted).chain(others.filter(differs)).collect()
    }

    /// Samples of a fresh run.
    #[must_use]
    pub fn samples_of_run(&self) -> usize {
        self.samples(self.duration_s())
    }

    /// Length of a fresh run in s.
    pub(super) fn duration_s(&self) -> f64 {
        self.fresh.duration_s
    }

    /// Index of the first sample with a fault.
    pub(super) fn fault_start(&self) -> usize {
        self.samples(self.faults.start_s)
    }

    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a sample index")]
    pub(super) fn samples(&self, seconds: f64) -> usize {
        (seconds / self.sample_time_s).round().max(0.0) as usize
    }

    /// Lets the relative paths of model files begin in a folder, that of the configuration.
    pub fn begin_in(&mut self, folder: &Path) {
        self.generators.iter_mut().for_each(|generator| generator.spec.begin_in(folder));
        let own = self.scenarios.iter_mut().filter_map(|scenario| scenario.own.as_mut());
        own.for_each(|own| own.begin_in(folder));
    }

    /// The model files that it names, each once.
    pub(super) fn model_files(&self) -> BTreeSet<&Path> {
        let generators = self.generators.iter().filter_map(|generator| generator.spec.model_file());
        let own = self.scenarios.iter().filter_map(|scenario| scenario.own.as_ref());
        generators
            .chain(own.flat_map(|own| own.model.file().into_iter().chain(own.plant.file())))
            .collect()
    }

    /// # Errors
    ///
    /// Returns the first setting that cannot be.
    pub fn check(&self) -> Result<(), CompareError> {
        if self.version != CONFIG_VERSION {
            let (expected, found) = (CONFIG_VERSION, self.version);
            return Err(CompareError::Version { expected, found });
        }
        check_limits(self, &Limits::default())?;
        let setting = |setting: &str, expected, found: String| {
            Err(CompareError::Setting { setting: setting.to_owned(), expected, found })
        };
        let counts = [
            ("engines.thresholds", self.engines.thresholds),
            ("engines.test", self.engines.test),
            ("engines.calibration_runs", self.engines.calibration_runs),
            ("engines.threshold_runs", self.engines.threshold_runs),
            ("engines.test_runs", self.engines.test_runs),
            ("engines.fault_runs", self.engines.fault_runs),
            ("scenarios", self.scenarios.len() as u64),
            ("generators", self.generators.len() as u64),
            ("biases", self.biases.len() as u64),
            ("detectors", self.detectors.len() as u64),
        ];
        for (name, count) in counts {
            if count == 0 {
                return setting(name, "at least 1", "0".to_owned());
            }
        }
        let Engines { test_runs, fault_runs, .. } = self.engines;
        if fault_runs > test_runs {
            let expected = "at most engines.test_runs: faults are laid on runs that are there";
            let found = format!("{fault_runs} of {test_runs} runs");
            return setting("engines.fault_runs", expected, found);
        }
        let runs = self.engines.thresholds * self.engines.threshold_runs;
        let resolved = self.false_alarms * (runs + 1) as f64;
        if !(self.false_alarms < 1.0 && resolved >= 1.0) {
            let expected = "a probability below 1 that the fault-free runs can resolve: \
                            false_alarms * (engines.thresholds * engines.threshold_runs + 1) >= 1";
            let found = format!("{} with {runs} runs", self.false_alarms);
            return setting("false_alarms", expected, found);
        }
        for (list, names) in [
            ("scenarios", names(&self.scenarios, |s| &s.name)),
            ("generators", names(&self.generators, |g| &g.name)),
            ("biases", names(&self.biases, |b| &b.name)),
            ("detectors", names(&self.detectors, |d| &d.name)),
        ] {
            let twice = (1..names.len()).find(|&i| names[..i].contains(&names[i]));
            if let Some(i) = twice {
                let found = format!("`{}` twice", names[i]);
                return setting(&format!("{list}.name"), "names that differ", found);
            }
        }
        for generator in &self.generators {
            if let Some(found) = generator.diagnose_s
                && !(is_diagnosed(&generator.spec) && found > 0.0 && found.is_finite())
            {
                let expected = "seconds above 0, for a `patched` generator with the text of a model of `engine17`";
                return setting("generators.diagnose_s", expected, found.to_string());
            }
        }
        self.faults.check(self.duration_s())
    }
}

fn names<T>(all: &[T], name: impl Fn(&T) -> &String) -> Vec<&str> {
    all.iter().map(|one| name(one).as_str()).collect()
}
