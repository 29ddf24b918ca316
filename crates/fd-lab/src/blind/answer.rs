//! What a diagnosis said of a case, one line of JSON per case.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::{
    baselines::Baselines,
    error::BlindError,
    truth::{Effect, Truth},
};
use crate::journal;

/// The word for an answer that names nothing.
pub(super) const UNCLEAR: &str = "unclear";

/// What a diagnosis said of a case.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Answer {
    /// Name of the case.
    pub case: String,
    /// Why there is no diagnosis, if there is none.
    pub error: Option<String>,
    /// The answer in one word: `no gap`, `cause`, `tied`, `pair`, `none of these`, `unclear`.
    pub verdict: String,
    /// Probability of no gap.
    pub no_gap: f64,
    /// How much speaks for none of the known causes; larger is more. A threshold on it is for who
    /// scores.
    pub none_score: f64,
    /// Whether the diagnosis itself says "none of these".
    pub says_none: bool,
    /// Causes, the most probable first.
    pub causes: Vec<Named>,
    /// Places of causes that the diagnosis cannot tell from the first one.
    pub tied: Vec<usize>,
    /// All causes that act together, when the diagnosis names more than one.
    pub together: Vec<Named>,
    /// Pairs of causes that may act together, with their probabilities.
    pub pairs: Vec<Together>,
    /// Root mean square of the training residual of each output, parameters refitted, with the
    /// answer, and that of the noise floor; in the unit of the output.
    pub gaps: [Vec<f64>; 3],
    /// What the diagnosis took for the noise of each output, in its unit.
    pub sigma: Vec<f64>,
    /// Outputs that are told to be logged in steps.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rounded: Vec<String>,
    /// Mistakes in the reading of the log: what was named, then what the diagnosis cannot tell from it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub reading: Vec<Reading>,
    /// Share of the gap left after a refit of the parameters that the answer closes on held-out
    /// data.
    pub closed: Option<Share>,
    /// Parameters after the null fit.
    pub refit: Vec<(String, f64)>,
    /// The simulator with the answer in it, as a model file.
    pub patched: Option<String>,
    /// Time of the diagnosis, in seconds.
    pub seconds: f64,
    /// Number of candidates that were tried.
    pub candidates: usize,
    /// Runs of a black box through the log that is fitted, where it was one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub runs: Option<f64>,
    /// What simpler methods say.
    pub baselines: Option<Baselines>,
}

/// A cause that was named.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Named {
    /// Label.
    pub label: String,
    /// Law.
    pub law: String,
    /// Mechanism.
    pub family: String,
    /// `input`, `dynamics` or `output`.
    pub side: String,
    /// Name of the site.
    pub site: String,
    /// The other end of a coupling.
    pub partner: Option<String>,
    /// Probability.
    pub probability: f64,
}

/// Two causes that may act together.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Together {
    /// Both of them.
    pub causes: [Named; 2],
    /// Probability that it is these two.
    pub probability: f64,
}

/// A mistake in the reading of the log that was named.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Reading {
    /// `sign`, `unit`, `swap`, `clock`, `time`, `zero` or `parameter`.
    pub kind: String,
    /// The channels that are read wrongly; none where it is time.
    pub channels: Vec<String>,
    /// What was read over what is real, for a unit or time.
    pub factor: Option<f64>,
    /// Samples by which it was logged late, for a clock.
    pub late: Option<f64>,
    /// Probability of what was named, with all that cannot be told from it.
    pub probability: f64,
    /// Whether it is what the diagnosis cannot tell from the one that was named.
    pub is_tied: bool,
}

/// A share of a gap with its interval.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Share {
    /// The share.
    pub fraction: f64,
    /// Its 95 % interval.
    pub interval: [f64; 2],
}

impl Answer {
    /// The answer with the quantised sensors of the `truth` named where they are told. No probability is theirs, as a
    /// log shows its steps: they count as found, and are no cause that was named alone.
    #[must_use]
    pub(super) fn with_steps_named(&self, truth: &Truth) -> Self {
        let is_told =
            |e: &&Effect| e.label == "sensor-quantisation" && self.rounded.contains(&e.site);
        let mut answer = self.clone();
        for effect in truth.effects.iter().filter(is_told) {
            let named = Named {
                label: effect.label.clone(),
                law: effect.law.clone(),
                family: effect.family.clone(),
                side: "output".to_owned(),
                site: effect.site.clone(),
                partner: None,
                probability: 1.0,
            };
            if answer.together.is_empty() {
                answer.together.extend(answer.first().cloned());
            }
            answer.together.push(named.clone());
            if answer.first().is_none() {
                answer.causes.insert(0, named);
                (answer.no_gap, answer.tied) = (0.0, vec![0]);
                UNCLEAR.clone_into(&mut answer.verdict);
            }
        }
        answer
    }

    /// The most probable cause, unless "no gap" is more probable than all causes together.
    #[must_use]
    pub fn first(&self) -> Option<&Named> {
        self.causes.first().filter(|_| self.no_gap < 0.5)
    }

    /// Probability that the simulator is to blame at all; not above one half when the answer is
    /// that the log cannot tell.
    #[must_use]
    pub fn blamed(&self) -> f64 {
        let blamed = 1.0 - self.no_gap;
        if self.verdict == UNCLEAR { blamed.min(0.5) } else { blamed }
    }
}

/// Reads the answers that are there, whole lines only; of two to one case the last one counts.
///
/// # Errors
///
/// Returns an error when the file cannot be read or a line is not an answer.
pub fn read_answers(file: &Path) -> Result<Vec<Answer>, BlindError> {
    let mut answers: Vec<Answer> = Vec::new();
    for answer in journal::read::<Answer>(file)? {
        answers.retain(|known| known.case != answer.case);
        answers.push(answer);
    }
    Ok(answers)
}
