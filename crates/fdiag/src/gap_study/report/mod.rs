//! The one result of a study: what `report.json` holds, and what headline, tables and page are made from.
//!
//! `docs/gap-report.md` describes it in words, `docs/gap-report.schema.json` is its JSON schema.

mod inputs;
mod schema;
mod settings;

use fd_gap::{
    calibrate::Confusion,
    ceiling::Ceiling,
    diagnose::{Cause, CauseId, Diagnosis, HeldOut, PairId, Verdict},
    experiment::Advice,
    fit::Horizon,
    locate::Location,
    reading::Reading,
    road::{CauseList, ListedCause},
};
use schemars::JsonSchema;
use serde::Serialize;

pub use self::{
    inputs::Inputs,
    schema::schema,
    settings::{HorizonKind, HorizonSource, StudySettings},
};
use super::{
    law::Law, log_finding::LogFinding, patched::PatchedModel, sparing::Sparing, whole::Whole,
};

/// The version of the schema; it rises when a key changes its meaning or disappears.
pub const REPORT_VERSION: u32 = 2;

/// All that a study says. Probabilities and shares are between 0 and 1 where nothing else is said; *sigma* is
/// the standard deviation of the noise of an output.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Report {
    /// Version of this schema.
    pub version: u32,
    /// What came out, in one sentence.
    pub headline: String,
    /// What the log, or the model, seems to say and does not mean; `null` when it is read as it is meant.
    /// Everything below is then of the mended log.
    pub reading: Option<Reading>,
    /// Which effect, how sure, how far the gap shrinks.
    pub diagnosis: Diagnosis,
    /// Several causes, one after another, where one does not explain the logs down to the noise; `null`
    /// elsewhere.
    pub road: Option<CauseList>,
    /// What to do next, the most useful first; never empty when the answer is tied, unclear or none of these.
    pub next: Vec<String>,
    /// Where the gap lies.
    pub location: Location,
    /// The fitted law of the first cause that the verdict names, along the simulation; `null` when
    /// there is none or it cannot be drawn.
    pub law: Option<Law>,
    /// What a black-box compensation could remove; `null` without held-out data.
    pub ceiling: Option<Ceiling>,
    /// What would separate what this log cannot; `null` when the answer is clear.
    pub advice: Option<Advice>,
    /// What the same diagnosis says of simulated logs of known cause; `null` when it was not asked for.
    pub calibration: Option<Confusion>,
    /// What is wrong with the logs, the worst first.
    pub findings: Vec<LogFinding>,
    /// How the answer does on all rows of long logs, of which only stretches were fitted; `null` elsewhere.
    pub whole: Option<Whole>,
    /// How a simulator outside of this program was diagnosed with few runs; `null` elsewhere.
    pub sparing: Option<Sparing>,
    /// What was left out because nobody wanted to wait any longer; empty if it came to its end.
    pub stopped: Vec<String>,
    /// The time limit that was reached, in seconds; `null` when none was, or somebody stopped it before.
    pub time_limit: Option<f64>,
    /// What was diagnosed.
    pub inputs: Inputs,
    /// How it was made.
    pub settings: StudySettings,
    /// Simulators with the cause in them, the best explanation first.
    pub models: Vec<PatchedModel>,
    /// How long it took; the one part that is not the same every time.
    pub timing: Timing,
}

/// How long it took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Timing {
    /// Wall clock, in seconds.
    pub seconds: f64,
    /// Threads.
    pub threads: usize,
}

impl Report {
    /// Several causes, if they are the answer.
    #[must_use]
    pub fn list(&self) -> Option<&CauseList> {
        self.road.as_ref().filter(|road| 1 < road.causes.len())
    }

    /// The causes that the answer names, alone, tied or together.
    #[must_use]
    pub fn named(&self) -> Vec<&Cause> {
        if self.spoiled().is_some() {
            return Vec::new();
        }
        if let Some(list) = self.list() {
            return list.causes.iter().map(|listed| &listed.cause).collect();
        }
        let Diagnosis { verdict, causes, pairs, tied, .. } = &self.diagnosis;
        match verdict {
            Verdict::Cause => causes.iter().take(1).collect(),
            Verdict::Tied => tied.iter().filter_map(|CauseId(place)| causes.get(*place)).collect(),
            Verdict::Pair => pairs.iter().take(1).flat_map(|pair| &pair.causes).collect(),
            Verdict::NoGap | Verdict::NoneOfThese | Verdict::Unclear => Vec::new(),
        }
    }

    /// The probability of a cause, alone or beside others: that of the list where it stands in one.
    #[must_use]
    pub fn probability(&self, cause: &Cause) -> f64 {
        let mut listed = self.list().into_iter().flat_map(|list| &list.causes);
        let is_it = |listed: &&ListedCause| listed.cause.identity() == cause.identity();
        let listed = listed.find(is_it).map(|listed| listed.probability);
        listed.unwrap_or_else(|| self.diagnosis.at_work(cause))
    }

    /// The causes that this log cannot tell apart; none when it can.
    #[must_use]
    pub fn tied(&self) -> &[CauseId] {
        let tied = &self.diagnosis.tied;
        if 1 < tied.len() { tied } else { &[] }
    }

    /// The pairs that this log cannot tell apart; none when it can.
    #[must_use]
    pub fn tied_pairs(&self) -> &[PairId] {
        let tied = &self.diagnosis.tied_pairs;
        if 1 < tied.len() { tied } else { &[] }
    }

    /// The held-out forecasts that the answer is told by: at the horizon that was asked for, else those that
    /// [say most](Diagnosis::forecast).
    #[must_use]
    pub fn forecast(&self) -> Option<&HeldOut> {
        let is_asked = |held_out: &&HeldOut| match (held_out.horizon, self.settings.window_s) {
            (Horizon::FreeRun, window) => window.is_none(),
            (Horizon::Windows { .. }, window) => window == Some(held_out.seconds),
        };
        let mut stated = self.diagnosis.held_out.iter();
        let stated = match self.settings.horizon_from {
            HorizonSource::Stated => stated.find(is_asked),
            HorizonSource::Memory => None,
        };
        stated.or_else(|| self.diagnosis.forecast())
    }

    /// The first cause that the verdict names, or the most probable one when it names none; none when
    /// there is no gap.
    #[must_use]
    pub fn first_cause(&self) -> Option<&Cause> {
        first_cause(&self.diagnosis)
    }

    /// The finding that makes every answer void, if there is one: a log that is not what it claims to be,
    /// or in which no output says anything.
    #[must_use]
    pub fn spoiled(&self) -> Option<&LogFinding> {
        let mislabelled = self.findings.iter().find(|finding| finding.defect.is_mislabelled());
        let is_still = |output: &str| {
            let still = |f: &&LogFinding| f.channel == output && f.defect.is_still();
            self.findings.iter().find(still)
        };
        mislabelled.or_else(|| {
            let outputs = self.inputs.outputs.iter();
            let still: Vec<_> = outputs.map(|output| is_still(&output.name)).collect();
            if still.iter().all(Option::is_some) {
                still.into_iter().flatten().next()
            } else {
                None
            }
        })
    }
}

pub(super) fn first_cause(diagnosis: &Diagnosis) -> Option<&Cause> {
    match diagnosis.verdict {
        Verdict::NoGap => None,
        Verdict::Pair => diagnosis.pairs.first().map(|pair| &pair.causes[0]),
        _ => diagnosis.causes.first(),
    }
}
