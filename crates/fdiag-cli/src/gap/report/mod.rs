//! The report as data: what `report.json` holds, and what pages and tables are made from.
//!
//! `docs/gap-report.md` describes every key. A number that is not known is `null`.

mod answer;
mod further;
mod input;
mod place;
mod shrink;

use serde::Serialize;

pub use self::{
    answer::{CauseReport, GroupReport, PairReport, ParameterReport, SideReport, SiteReport},
    further::{
        AdviceReport, CalibrationReport, CeilingReport, CompensationReport, TriedExperiment,
    },
    input::{FindingReport, InputReport, LogReport, NoiseReport, NuisanceReport, SettingsReport},
    place::{
        BandReport, BinReport, ChannelReport, LawReport, PlaceReport, RegionReport, SizeReport,
        SpectrumReport, StretchReport, TimesReport, WhereReport,
    },
    shrink::{ClosedReport, HorizonReport, OutputGap},
};

/// The version of this schema; it rises when a key changes its meaning or disappears.
pub const REPORT_VERSION: u32 = 1;

/// All that a diagnosis says.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Report {
    /// Version of this schema.
    pub version: u32,
    /// What came out, in one sentence.
    pub headline: String,
    /// `no-gap`, `cause`, `tied`, `pair`, `none-of-these` or `unclear`.
    pub verdict: &'static str,
    /// What probabilities rest on: `at-the-floor` (likelihood) or `above-the-floor` (forecasts).
    pub regime: &'static str,
    /// Probability that the refitted model explains the logs.
    pub no_gap: f64,
    /// Probability that nothing that was tried is right.
    pub none_of_these: f64,
    /// Mechanisms at places, the most probable first.
    pub groups: Vec<GroupReport>,
    /// Sides of the plant, the most probable first.
    pub sides: Vec<SideReport>,
    /// Single causes, the most probable first.
    pub causes: Vec<CauseReport>,
    /// Pairs of causes, the best first.
    pub pairs: Vec<PairReport>,
    /// Where the gap lies.
    pub location: WhereReport,
    /// How far it shrinks on held-out data, the horizon of the fit first.
    pub how_far: Vec<HorizonReport>,
    /// What is left with the best explanation, in words; empty when nothing is.
    pub remains: String,
    /// The fitted law, along the simulation.
    pub law: Option<LawReport>,
    /// What a black-box compensation could remove.
    pub ceiling: Option<CeilingReport>,
    /// What would separate what this log cannot.
    pub next: Option<AdviceReport>,
    /// What the same diagnosis says of simulated logs of known cause.
    pub calibration: Option<CalibrationReport>,
    /// What is wrong with the logs, the worst first.
    pub findings: Vec<FindingReport>,
    /// What was diagnosed.
    pub input: InputReport,
    /// Noise of the outputs.
    pub noise: Vec<NoiseReport>,
    /// Whether the best explanation leaves clearly more than the floor.
    pub is_unexplained: bool,
    /// Whether the noise is coloured.
    pub is_coloured: bool,
    /// Why to doubt that the best explanation is all there is.
    pub leftover: LeftoverReport,
    /// Parameters of the model as they were refitted with the best explanation.
    pub parameters: Vec<NuisanceReport>,
    /// What could not be tried.
    pub not_tested: Vec<NotTestedReport>,
    /// Files beside this one.
    pub files: Vec<FileReport>,
    /// How it was made.
    pub settings: SettingsReport,
    /// How much work it was.
    pub work: WorkReport,
    /// How long it took; the one part that is not the same every time.
    pub timing: TimingReport,
}

/// What the best explanation leaves, beyond noise of the stated kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct LeftoverReport {
    /// Gain of the log-likelihood that is left in the level and the colour of residuals.
    pub level: f64,
    /// Gain that is left in what inputs, outputs and time still predict.
    pub pattern: f64,
    /// Share of the amplitude of the gap of the refitted model that is left.
    pub share: f64,
}

/// A candidate that could not be tried.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct NotTestedReport {
    /// Label of the effect.
    pub label: &'static str,
    /// The law.
    pub law: &'static str,
    /// Where it would be.
    pub site: SiteReport,
    /// Why not.
    pub reason: String,
}

/// A file of the report.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FileReport {
    /// Its name, in the directory of the report.
    pub file: String,
    /// What it is.
    pub content: String,
}

/// How much work it was.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct WorkReport {
    /// Causes that were ranked.
    pub causes: usize,
    /// Simulations of all logs.
    pub simulations: usize,
}

/// How long it took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct TimingReport {
    /// Seconds of wall clock.
    pub seconds: f64,
    /// Threads.
    pub threads: usize,
}
