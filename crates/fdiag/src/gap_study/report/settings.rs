//! How a study was made.

use fd_effect::text::TextEffect;
use fd_gap::{
    diagnose::{ControllerSees, Settings},
    fit::Horizon,
};
use schemars::JsonSchema;
use serde::Serialize;

use crate::gap_study::request::{HeldOutChoice, HorizonChoice, Named, Request, StartsChoice};

/// How a study was made. All probabilities are between 0 and 1.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct StudySettings {
    /// Seed of everything random.
    pub seed: u64,
    /// Horizon of the fits.
    pub horizon: HorizonKind,
    /// Length of the windows, in seconds; `null` for a free run.
    pub window_s: Option<f64>,
    /// Where the horizon comes from.
    pub horizon_from: HorizonSource,
    /// Share of each log that was fitted to, 0 to 1, when its end was held out.
    pub split: Option<f64>,
    /// Effects of the request's own that were tried, as `LABEL: LAW`.
    pub effects: Vec<String>,
    /// Effects that were not tried.
    pub exclude: Vec<String>,
    /// The only effects that were tried; empty for all.
    pub only: Vec<String>,
    /// Relative tolerances of parameters that the request states, as `NAME=VALUE`.
    #[schemars(with = "Vec<String>")]
    pub tolerances: Vec<Named>,
    /// Noise that the request states, as `OUTPUT=VALUE`; standard deviations in the unit of the output.
    #[schemars(with = "Vec<String>")]
    pub noise: Vec<Named>,
    /// Whether the log was taken as it is read, without asking for mistakes of reading.
    pub as_read: bool,
    /// Where the logs were taken to begin.
    pub starts: StartsChoice,
    /// What a controller of the model was to act on.
    pub controller_sees: ControllerSees,
    /// Causes that were fitted to the end.
    pub finalists: usize,
    /// Probability of no gap before the data.
    pub prior_no_gap: f64,
    /// Probability before the data that a gap has a cause that is not among those tried.
    pub prior_unknown: f64,
    /// Probability before the data that a gap has two causes.
    pub prior_two: f64,
    /// What the logarithm of the evidence was divided by; a pure number.
    pub temperature: f64,
    /// Bayes factor within which causes are rivals; a pure number.
    pub bayes_factor: f64,
    /// Replicas of the bootstrap.
    pub bootstrap_replicas: usize,
    /// Replicas per cause of the self-calibration; `null` when there was none.
    pub calibration_replicas: Option<usize>,
}

/// How long a simulation of a fit runs without seeing the outputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum HorizonKind {
    /// Through the whole log.
    FreeRun,
    /// Through windows.
    Windows,
    /// Through the whole log, corrected at each sample by what it has missed: for plants that run away from any
    /// start.
    Following,
}

/// Where a horizon comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub enum HorizonSource {
    /// The request states it.
    #[serde(rename = "stated")]
    Stated,
    /// It follows from how long the model remembers its initial state.
    #[serde(rename = "memory of the model")]
    Memory,
}

impl StudySettings {
    /// `ts` is the time between samples, in seconds.
    pub(in crate::gap_study) fn of(
        request: &Request,
        settings: &Settings,
        ts: f64,
        is_followed: bool,
    ) -> Self {
        let (horizon, window_s) = match settings.horizon {
            Horizon::FreeRun if is_followed => (HorizonKind::Following, None),
            Horizon::FreeRun => (HorizonKind::FreeRun, None),
            Horizon::Windows { samples } => (HorizonKind::Windows, Some(samples as f64 * ts)),
        };
        Self {
            seed: request.seed,
            horizon,
            window_s,
            horizon_from: match request.horizon {
                HorizonChoice::Auto => HorizonSource::Memory,
                HorizonChoice::Free | HorizonChoice::Seconds(_) => HorizonSource::Stated,
            },
            split: match request.held_out {
                HeldOutChoice::Split(share) => Some(share),
                HeldOutChoice::Logs(_) => None,
            },
            effects: request.effects.iter().map(TextEffect::shown).collect(),
            exclude: request.exclude.clone(),
            only: request.only.clone(),
            tolerances: request.tolerances.clone(),
            noise: request.noise.clone(),
            as_read: request.as_read,
            starts: request.starts,
            controller_sees: request.controller_sees,
            finalists: settings.finalists,
            prior_no_gap: settings.no_gap,
            prior_unknown: settings.unknown,
            prior_two: settings.two,
            temperature: settings.temperature,
            bayes_factor: settings.bayes_factor,
            bootstrap_replicas: settings.replicas,
            calibration_replicas: request.calibrate,
        }
    }
}
