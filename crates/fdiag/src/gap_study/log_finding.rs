//! What is wrong with a log, with the name of its file.

use std::path::Path;

use fd_gap::quality::{Defect, Severity};
use fd_model::Channel;
use schemars::JsonSchema;
use serde::Serialize;

use super::log_part::file_name;

/// Something that is wrong with a log.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct LogFinding {
    /// How bad it is.
    pub severity: Severity,
    /// Name of the file; of the simulator, where that is what the finding is about.
    pub file: String,
    /// Name of the channel; `time` for the time base.
    pub channel: String,
    /// What was found.
    pub defect: LogDefect,
}

/// What was found in a log.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum LogDefect {
    /// In a channel.
    Channel(Defect),
    /// In the time base.
    TimeBase(TimeBaseDefect),
    /// In the simulator that the log is compared with.
    Simulator(SimulatorDefect),
}

/// What was found in a simulator outside of this program.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum SimulatorDefect {
    /// Equal runs differ: their spread is part of the noise of the output.
    NotRepeatable {
        /// Standard deviation of the output among equal runs, in its unit.
        spread: f64,
        /// That unit.
        unit: String,
        /// Equal runs that were made to measure it.
        runs: usize,
    },
}

/// What was found in the time base of a log.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum TimeBaseDefect {
    /// Holes are too long to be bridged.
    Holes {
        /// Number of holes.
        count: usize,
    },
    /// Rows are not evenly spaced.
    Uneven {
        /// Median time between rows, in seconds.
        median_step_s: f64,
        /// Largest deviation of a step from the median, in seconds.
        jitter_s: f64,
        /// Time between the samples that it was brought to, in seconds.
        step_s: f64,
    },
    /// The samples that are simulated are further apart than the rows: inputs that move in between act on the plant as
    /// they were, and on the simulation as their mean.
    Coarse {
        /// Median time between rows, in seconds.
        median_step_s: f64,
        /// Time between the samples that it was brought to, in seconds.
        step_s: f64,
    },
    /// The log has another pace than the model, which is simulated at that of the log.
    Pace {
        /// Time between samples of the log, in seconds.
        log_s: f64,
        /// Time between samples of the model, in seconds.
        model_s: f64,
    },
    /// The effect depends on the time since the start of a run, and held-out logs have a start of their
    /// own: what it does there may not carry over.
    Clock,
}

impl LogFinding {
    /// What was found in a channel while a file was read.
    pub(super) fn of(path: &Path, channel: String, defect: Defect) -> Self {
        let severity = defect.severity();
        let (file, defect) = (file_name(path), LogDefect::Channel(defect));
        Self { severity, file, channel, defect }
    }

    /// An output that differs between equal runs of a simulator of that name.
    pub(super) fn of_simulator(name: &str, output: &Channel, spread: f64, runs: usize) -> Self {
        let unit = output.unit.clone();
        let defect = LogDefect::Simulator(SimulatorDefect::NotRepeatable { spread, unit, runs });
        let (severity, file) = (Severity::Warning, name.to_owned());
        Self { severity, file, channel: output.name.clone(), defect }
    }
}

impl LogDefect {
    /// Whether the log is not what it claims to be, so that no cause can be named.
    #[must_use]
    pub fn is_mislabelled(&self) -> bool {
        let Self::Channel(defect) = self else { return false };
        matches!(
            defect,
            Defect::WrongUnit { .. }
                | Defect::Swapped { .. }
                | Defect::Undriven
                | Defect::Unresponsive { .. }
                | Defect::Wrapped { .. }
        )
    }

    /// Whether the channel says nothing.
    #[must_use]
    pub fn is_still(&self) -> bool {
        matches!(self, Self::Channel(Defect::NotExcited | Defect::Constant))
    }
}
