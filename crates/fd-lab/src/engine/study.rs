//! Many seeds in parallel, and what they say together.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{
    benchmark::Benchmark, config::EngineConfig, error::EngineStudyError, on_line::OnLineSummary,
    range::Range, trial::Trial,
};
use fdiag::Watcher;

/// The version of the JSON report.
pub const REPORT_VERSION: u32 = 1;

/// The result of the benchmark.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Study {
    /// Version of this schema.
    pub version: u32,
    /// What was run.
    pub config: EngineConfig,
    /// Name of the engine.
    pub engine: String,
    /// Summary over all seeds.
    pub summary: Summary,
    /// Every seed.
    pub trials: Vec<Trial>,
    /// Seeds for which no diagnosis could be trained, with the reason.
    pub failed: Vec<(u64, String)>,
}

/// Medians and ranges over the seeds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Largest fault-free magnitude of the primary residual.
    pub fault_free_primary: Range,
    /// Largest fault-free magnitude of the compensated residual.
    pub fault_free_compensated: Range,
    /// How many times the compensation made it smaller.
    pub fault_free_ratio: Range,
    /// The same over the test runs.
    pub fault_free_test_ratio: Range,
    /// Share of fault-free test runs with an alarm, without compensation.
    pub false_alarms_primary: f64,
    /// Share of fault-free test runs with an alarm, with compensation.
    pub false_alarms_compensated: f64,
    /// One entry per faulty sensor.
    pub faults: Vec<FaultSummary>,
    /// What happened on line.
    #[serde(default)]
    pub on_line: Option<OnLineSummary>,
}

/// Medians and ranges for one faulty sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FaultSummary {
    /// Name of the sensor.
    pub sensor: String,
    /// Steady residual for a fault of size 1.
    pub residual_gain: Range,
    /// Smallest detectable size without compensation, relative to the reading.
    pub smallest_primary: Range,
    /// Smallest detectable size with compensation, relative to the reading.
    pub smallest_compensated: Range,
    /// How many times the compensation made it smaller.
    pub smallest_ratio: Range,
    /// Smallest detectable size with the best constant threshold on the residual vector.
    pub vector_primary: Range,
    /// The same on the compensated vector.
    pub vector_compensated: Range,
    /// How many times smaller compensation made it next to the best constant threshold on the vector.
    pub fair_ratio: Range,
    /// How many times smaller it became with the best constant threshold on either vector.
    pub vector_ratio: Range,
    /// Share of runs in which the fault of the configured size is found without compensation.
    pub found_primary: f64,
    /// The same with compensation.
    pub found_compensated: f64,
    /// Estimated over true size of that fault, with compensation.
    pub estimated: Range,
    /// Delay in s with compensation.
    pub delay_compensated_s: Range,
}

impl Benchmark {
    /// Runs all seeds on the threads of the current rayon pool.
    ///
    /// The result does not depend on the number of threads: each seed draws from a generator of
    /// its own and the trials are kept in order. Where the watcher stops it, the trials are those that had been begun,
    /// one at least.
    ///
    /// # Errors
    ///
    /// Returns an error when the configuration asks for no runs, or when no seed at all could be
    /// trained. Single seeds that fail are listed in the result.
    pub fn study(&self, watcher: &impl Watcher) -> Result<Study, EngineStudyError> {
        let config = self.config();
        for (setting, count) in [
            ("seeds", config.seeds),
            ("calibration_runs", config.calibration_runs as u64),
            ("test_runs", config.test_runs as u64),
        ] {
            if count == 0 {
                return Err(EngineStudyError::None { setting });
            }
        }
        self.fault_channels()?;
        watcher.begin(config.seeds, 0);
        let results: Vec<(u64, Result<Trial, EngineStudyError>)> = (0..config.seeds)
            .into_par_iter()
            .filter_map(|i| {
                if 0 < i && watcher.is_stopped() {
                    return None;
                }
                // After the largest seed comes 0.
                let seed = config.first_seed.wrapping_add(i);
                let trial = self.trial(seed);
                watcher.advance();
                Some((seed, trial))
            })
            .collect();
        let (mut trials, mut failed, mut first_error) = (Vec::new(), Vec::new(), None);
        for (seed, result) in results {
            match result {
                Ok(trial) => trials.push(trial),
                Err(error) => {
                    failed.push((seed, error.to_string()));
                    first_error.get_or_insert((seed, error));
                }
            }
        }
        if let (true, Some((seed, error))) = (trials.is_empty(), first_error) {
            return Err(EngineStudyError::Seed { seed, error: Box::new(error) });
        }
        Ok(Study {
            version: REPORT_VERSION,
            config: config.clone(),
            engine: self.engine_name().to_owned(),
            summary: Summary::of(&trials),
            trials,
            failed,
        })
    }
}

impl Summary {
    fn of(trials: &[Trial]) -> Self {
        let mean = |f: &dyn Fn(&Trial) -> f64| {
            let values = trials.iter().map(f).filter(|v| v.is_finite());
            let (sum, count) = values.fold((0.0, 0_usize), |(s, n), v| (s + v, n + 1));
            sum / count as f64
        };
        let range = |f: &dyn Fn(&Trial) -> f64| Range::of(trials.iter().map(f));
        let sensors = trials.first().map_or(0, |trial| trial.faults.len());
        let faults = (0..sensors).map(|i| FaultSummary {
            sensor: trials[0].faults[i].sensor.clone(),
            residual_gain: range(&|t| t.faults[i].residual_gain),
            smallest_primary: range(&|t| t.faults[i].smallest.primary),
            smallest_compensated: range(&|t| t.faults[i].smallest.compensated),
            smallest_ratio: range(&|t| t.faults[i].smallest.ratio()),
            vector_primary: range(&|t| t.faults[i].smallest_of_vector.primary),
            vector_compensated: range(&|t| t.faults[i].smallest_of_vector.compensated),
            fair_ratio: range(&|t| {
                t.faults[i].smallest_of_vector.primary / t.faults[i].smallest.compensated
            }),
            vector_ratio: range(&|t| t.faults[i].smallest_of_vector.ratio()),
            found_primary: mean(&|t| t.faults[i].found.primary),
            found_compensated: mean(&|t| t.faults[i].found.compensated),
            estimated: range(&|t| t.faults[i].estimated),
            delay_compensated_s: range(&|t| t.faults[i].delay_s.compensated),
        });
        Self {
            fault_free_primary: range(&|t| t.fault_free.primary),
            fault_free_compensated: range(&|t| t.fault_free.compensated),
            fault_free_ratio: range(&|t| t.fault_free.ratio()),
            fault_free_test_ratio: range(&|t| t.fault_free_test.ratio()),
            false_alarms_primary: mean(&|t| t.false_alarms.primary),
            false_alarms_compensated: mean(&|t| t.false_alarms.compensated),
            faults: faults.collect(),
            on_line: OnLineSummary::of(trials),
        }
    }
}
