//! Where a gap lies.

use fd_effect::{Side, SiteRef};
use fd_model::Channel;
use schemars::JsonSchema;
use serde::Serialize;

/// Where a gap lies, seen from several sides. Every part has a sentence in words, and claims only
/// what is significant: a part that finds nothing says so.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Location {
    /// Gap of each output.
    pub channels: Vec<ChannelGap>,
    /// Sides of the plant, the most probable first.
    pub sides: Vec<SideEvidence>,
    /// Inputs, forces, state equations and outputs, the most probable first and then those at which
    /// a free signal explains more.
    pub places: Vec<PlaceEvidence>,
    /// Power of the gap of each output over frequency.
    pub spectra: Vec<Spectrum>,
    /// What the missing signal at the most probable place (or the residual of an output) depends
    /// on, the strongest dependence first.
    pub regions: Vec<Region>,
    /// The gap over time, one entry per log.
    pub times: Vec<TimeCourse>,
}

/// Size of a gap.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Size {
    /// Root mean square, in the unit of the output.
    pub value: f64,
    /// The same in standard deviations of the noise.
    pub sigma: f64,
}

/// The gap of an output, on the training logs.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ChannelGap {
    /// Name and unit.
    pub output: Channel,
    /// With nominal parameters.
    pub nominal: Size,
    /// With parameters refitted.
    pub refit: Size,
    /// With the best explanation.
    pub after: Size,
    /// Noise floor.
    pub floor: Size,
    /// In words.
    pub statement: String,
}

/// How probable it is that the cause is on a side of the plant.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct SideEvidence {
    /// Side.
    pub side: Side,
    /// Sum of the probabilities of its causes.
    pub probability: f64,
    /// Largest share of the gap that a free signal at one of its places explains; `None` when none
    /// could be tried.
    pub free_share: Option<f64>,
    /// In words.
    pub statement: String,
}

/// How probable it is that the cause is at a place.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct PlaceEvidence {
    /// Input, force site, state or output.
    pub site: SiteRef,
    /// Side of the plant.
    pub side: Side,
    /// States whose equations a force here enters; empty for inputs and outputs.
    pub equations: Vec<String>,
    /// Sum of the probabilities of the causes at this place; that of a parameter counts for the
    /// states whose equations it is in, divided evenly.
    pub probability: f64,
    /// The free signal that would explain most; `None` when the model cannot be patched here or the
    /// place does not move any output.
    pub free: Option<FreeSignal>,
    /// In words.
    pub statement: String,
}

/// An unknown signal at a place (added to an input, a force, a rate or an output), estimated from
/// what the refitted model leaves: linear between knots, a priori Gaussian with a size that the log
/// settles (empirical Bayes).
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct FreeSignal {
    /// Share of the reducible gap (mean square above the floor) that it explains, less what as many
    /// free numbers explain of noise; between 0 and 1.
    pub share: f64,
    /// Natural logarithm of its evidence over that of no signal.
    pub log_evidence: f64,
    /// Unit.
    pub unit: String,
    /// Root mean square, in that unit.
    pub rms: f64,
    /// Its values at all samples, log by log; not serialised.
    #[serde(skip)]
    pub values: Vec<Vec<f64>>,
}

/// Power of the gap of an output over frequency, in squares of the noise per sample: values of all
/// bands add up to the mean square.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Spectrum {
    /// Name of the output.
    pub output: String,
    /// Bands from low to high.
    pub bands: Vec<Band>,
    /// In words.
    pub statement: String,
}

/// A frequency band.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Band {
    /// Lower end, in Hz.
    pub low_hz: f64,
    /// Upper end, in Hz.
    pub high_hz: f64,
    /// Power with parameters refitted, in squares of the noise per sample.
    pub refit: f64,
    /// Power with the best explanation, in squares of the noise per sample.
    pub after: f64,
    /// Power of the noise floor, in squares of the noise per sample.
    pub floor: f64,
    /// Share of the power above the floor, of all bands; with parameters refitted.
    pub share: f64,
    /// Whether the refitted model leaves significantly more than the floor here.
    pub is_above_floor: bool,
    /// Whether the best explanation does.
    pub is_above_floor_after: bool,
    /// Share of the power that is linear in an input (squared coherence of Welch's spectra), per
    /// input; `None` where the logs are too short for it.
    pub coherence: Vec<Option<f64>>,
}

/// What a gap depends on: one signal, cut into bins.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Region {
    /// What is looked at.
    pub of: RegionOf,
    /// The signal that it may depend on.
    pub on: RegionOn,
    /// Unit of the signal.
    pub unit: String,
    /// Bins from low to high, with about as many samples each.
    pub bins: Vec<Bin>,
    /// Correlation ratio η² of the values with the bins, corrected for their number: share of the
    /// variance that the means of the bins explain.
    pub level_share: f64,
    /// The same for the squares of the values: whether the *size* depends on the signal.
    pub size_share: f64,
    /// Probability that shares as large as the larger of the two come by chance, among all
    /// signals tried (circular shifts).
    pub p_value: f64,
    /// Whether it is below 5 % and the share is not negligible.
    pub is_significant: bool,
    /// In words.
    pub statement: String,
}

/// What may depend on a region.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(tag = "kind", content = "at", rename_all = "kebab-case")]
pub enum RegionOf {
    /// The residual of an output (measured less simulated, in sigma), by name.
    Residual(String),
    /// The free signal at a place, in its unit.
    Signal(SiteRef),
}

/// A signal that defines regions.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(tag = "kind", content = "name", rename_all = "kebab-case")]
pub enum RegionOn {
    /// An input.
    Input(String),
    /// Magnitude of an input, about its mean.
    InputAmplitude(String),
    /// A simulated state.
    State(String),
    /// Magnitude of a state, about its mean.
    StateAmplitude(String),
    /// A simulated output.
    Output(String),
    /// Velocity at a force site: two bins, backward and forward.
    Direction(String),
}

/// A bin of a region.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Bin {
    /// Lowest value of the signal, in its unit.
    pub low: f64,
    /// Highest value of the signal, in its unit.
    pub high: f64,
    /// Samples.
    pub count: usize,
    /// Mean of what is looked at: a residual in sigma, a free signal in its unit.
    pub mean: f64,
    /// Its root mean square, alike.
    pub rms: f64,
}

/// The gap over the time of a log, all outputs together.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct TimeCourse {
    /// Place of the log among the training logs, from 0.
    pub log: usize,
    /// Stretches of about the same length.
    pub stretches: Vec<Stretch>,
    /// The stretch in which the gap is larger or smaller than before and after, if there is one.
    pub change: Option<Change>,
    /// In words.
    pub statement: String,
}

/// Part of a log.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Stretch {
    /// Begin, in seconds from the start of the log.
    pub from: f64,
    /// End, in seconds from the start of the log.
    pub to: f64,
    /// Gap with parameters refitted, in sigma.
    pub refit: f64,
    /// Gap with the best explanation, in sigma.
    pub after: f64,
}

/// A change of the size of the gap.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Change {
    /// Begin, in seconds from the start of the log.
    pub from: f64,
    /// End, in seconds from the start of the log; the end of the log when it does not go back.
    pub to: f64,
    /// Gap inside, in sigma.
    pub inside: f64,
    /// Gap outside, in sigma.
    pub outside: f64,
    /// Probability of such a change by chance (permuted blocks).
    pub p_value: f64,
}
