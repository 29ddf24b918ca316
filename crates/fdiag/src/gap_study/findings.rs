//! Findings about logs, with the names of their files.

use std::{cmp::Reverse, path::Path};

use fd_gap::{
    diagnose::Diagnosis,
    quality::{Defect, Finding, Severity},
};
use fd_model::{Channel, SampleTime};
use fd_sim::model::Model;
use schemars::JsonSchema;
use serde::Serialize;

use super::{data::Data, report::file_name};

/// Rows per sample from which some are skipped.
const SKIPPING: f64 = 1.5;
/// Steps of a file may differ from that of the model by this part before it is worth a note.
const SAME_PACE: f64 = 1e-3;

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

/// Findings of a diagnosis, of the time bases, and those of the simulator that are known, the worst first.
pub(super) fn findings(
    diagnosis: &Diagnosis,
    data: &Data,
    nominal: &Model,
    of_simulator: Vec<LogFinding>,
) -> Vec<LogFinding> {
    let of_channel = |finding: &Finding| LogFinding {
        severity: finding.severity(),
        file: data.parts.get(finding.log - 1).map_or_else(String::new, |part| part.file.clone()),
        channel: finding.channel.clone(),
        defect: LogDefect::Channel(finding.defect.clone()),
    };
    let of_time = |severity, file: &str, defect| LogFinding {
        severity,
        file: file.to_owned(),
        channel: "time".to_owned(),
        defect: LogDefect::TimeBase(defect),
    };
    let mut all: Vec<LogFinding> = diagnosis.findings.iter().map(of_channel).collect();
    for part in data.parts.iter().filter(|part| part.samples[0] == 0) {
        let base = &part.time_base;
        if !base.gaps.is_empty() {
            let holes = TimeBaseDefect::Holes { count: base.gaps.len() };
            all.push(of_time(Severity::Note, &part.file, holes));
        }
        // Less is jitter: the median of the rows is what a grid is made of.
        if SKIPPING * base.median_step_s < base.step_s && !nominal.inputs.is_empty() {
            let (median_step_s, step_s) = (base.median_step_s, base.step_s);
            let coarse = TimeBaseDefect::Coarse { median_step_s, step_s };
            all.push(of_time(Severity::Warning, &part.file, coarse));
        }
        if !base.even {
            let uneven = TimeBaseDefect::Uneven {
                median_step_s: base.median_step_s,
                jitter_s: base.jitter_s,
                step_s: base.step_s,
            };
            all.push(of_time(Severity::Note, &part.file, uneven));
        }
    }
    let first = data.parts.first().map_or("", |part| part.file.as_str());
    let model_s = nominal.sample_time;
    let log_s = data.ts().map_or(model_s, SampleTime::seconds);
    if SAME_PACE * model_s < (log_s - model_s).abs() {
        all.push(of_time(Severity::Note, first, TimeBaseDefect::Pace { log_s, model_s }));
    }
    if !data.is_on_one_clock() && depends_on_time(nominal, &diagnosis.best.model) {
        all.push(of_time(Severity::Warning, first, TimeBaseDefect::Clock));
    }
    all.extend(data.findings.iter().cloned());
    all.extend(of_simulator);
    all.sort_by_key(|finding| Reverse(finding.severity));
    all
}

/// Whether what a patch has added mentions the time.
fn depends_on_time(nominal: &Model, patched: &Model) -> bool {
    let count = |model: &Model| {
        let definitions = model.definitions.iter().map(|d| &d.value);
        let laws = model.all_states().map(|state| state.law.expr());
        let outputs = model.outputs.iter().map(|output| &output.value);
        definitions.chain(laws).chain(outputs).filter(|expr| expr.mentions("t")).count()
    };
    count(nominal) < count(patched)
}
