//! What was diagnosed, and how.

use serde::Serialize;

/// What was diagnosed.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct InputReport {
    /// Model file.
    pub model_file: String,
    /// Name of the model.
    pub model: String,
    /// Runs and parts of runs, fitted ones first.
    pub logs: Vec<LogReport>,
    /// Time between samples, in seconds.
    pub sample_time_s: f64,
    /// What was done with uneven and missing samples, in words.
    pub policy: String,
    /// How long the model remembers its initial state, in seconds; of what it forgets.
    pub memory_s: Option<f64>,
    /// Whether it forgets all of it within a third of the longest log.
    pub forgets: bool,
}

/// A run, or a part of one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LogReport {
    /// The file.
    pub file: String,
    /// `fit` or `held-out`.
    pub role: &'static str,
    /// Samples in this part.
    pub samples: usize,
    /// Begin, in seconds from the start of the file.
    pub from_s: f64,
    /// End, in seconds from the start of the file.
    pub to_s: f64,
    /// Rows of the file.
    pub rows: usize,
    /// Whether the time base of the file is even.
    pub is_even: bool,
    /// Largest deviation of a step from the median, in seconds.
    pub jitter_s: f64,
    /// Holes that were too long to be bridged.
    pub gaps: usize,
    /// Rows left out because their time was not later than the one before.
    pub left_out: usize,
    /// Share of the output values in this part that are missing.
    pub missing_share: f64,
}

/// Noise of an output.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct NoiseReport {
    /// Name of the output.
    pub output: String,
    /// Its unit.
    pub unit: String,
    /// Standard deviation of its noise as the model states it.
    pub stated: Option<f64>,
    /// Standard deviation that residuals are measured in: one sigma.
    pub sigma: f64,
    /// Noise floor below the best explanation.
    pub floor: f64,
}

/// A parameter of the model that was refitted.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct NuisanceReport {
    /// Name.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Value in the model file.
    pub nominal: f64,
    /// Refitted value.
    pub refitted: f64,
    /// Deviation, in standard deviations of what the user says to know.
    pub deviation_sd: f64,
}

/// Something that is wrong with a log.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct FindingReport {
    /// `serious`, `warning` or `note`.
    pub severity: &'static str,
    /// `wrong-unit`, `swapped`, `not-excited`, `constant`, `clipped`, `quantised`, `missing`,
    /// `slow-sampling`, `feedback`, `uneven`, `pace`, `clock` or `other`.
    pub kind: &'static str,
    /// The file.
    pub file: String,
    /// The channel.
    pub channel: String,
    /// In words.
    pub text: String,
}

/// How the diagnosis was made.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SettingsReport {
    /// Seed of everything random.
    pub seed: u64,
    /// Horizon of the fits: `free-run` or `windows`.
    pub horizon: &'static str,
    /// Length of the windows, in seconds.
    pub window_s: Option<f64>,
    /// Whether that was stated or follows from the memory of the model.
    pub horizon_from: &'static str,
    /// Share of each log that was fitted to, when its end was held out.
    pub split: Option<f64>,
    /// Effects that were not tried.
    pub exclude: Vec<String>,
    /// The only effects that were tried; empty for all.
    pub only: Vec<String>,
    /// Tolerances stated on the command line, as `NAME=VALUE`.
    pub tolerances: Vec<String>,
    /// Noise stated on the command line, as `OUTPUT=VALUE`.
    pub noise: Vec<String>,
    /// Causes that were fitted to the end.
    pub finalists: usize,
    /// Probability of no gap before the data.
    pub prior_no_gap: f64,
    /// Probability before the data that a gap has a cause that is not among those tried.
    pub prior_unknown: f64,
    /// Probability before the data that a gap has two causes.
    pub prior_two: f64,
    /// What evidence was divided by.
    pub temperature: f64,
    /// Bayes factor within which causes are rivals.
    pub bayes_factor: f64,
    /// Replicas of the bootstrap.
    pub bootstrap_replicas: usize,
    /// Replicas per cause of the self-calibration; none when there was none.
    pub calibration_replicas: Option<usize>,
}
