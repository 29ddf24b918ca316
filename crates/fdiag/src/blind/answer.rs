//! What a diagnosis said of a case, one line of JSON per case.

use std::{fs, io::Write, path::Path};

use serde::{Deserialize, Serialize};

use super::{baselines::Baselines, error::BlindError};

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
/// Returns an error when the file cannot be read or a line before the last is not an answer.
pub fn read_answers(file: &Path) -> Result<Vec<Answer>, BlindError> {
    if !file.exists() {
        return Ok(Vec::new());
    }
    let text = fs::read_to_string(file).map_err(BlindError::file(file))?;
    let mut answers: Vec<Answer> = Vec::new();
    let lines: Vec<&str> = text.lines().collect();
    for (i, line) in lines.iter().enumerate() {
        match serde_json::from_str::<Answer>(line) {
            Ok(answer) => {
                answers.retain(|known| known.case != answer.case);
                answers.push(answer);
            }
            // A run that was killed while it wrote.
            Err(_) if i + 1 == lines.len() && !text.ends_with('\n') => {}
            Err(error) => {
                return Err(BlindError::content(file, format!("line {}: {error}", i + 1)));
            }
        }
    }
    Ok(answers)
}

/// Adds an answer to a file.
pub(super) fn append(file: &mut fs::File, path: &Path, answer: &Answer) -> Result<(), BlindError> {
    let mut line = serde_json::to_string(answer).map_err(|e| BlindError::content(path, e))?;
    line.push('\n');
    file.write_all(line.as_bytes()).map_err(BlindError::file(path))
}

/// Cuts off what a killed run left of a line.
pub(super) fn mend(file: &Path) -> Result<(), BlindError> {
    let Ok(text) = fs::read(file) else { return Ok(()) };
    let whole = text.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
    if whole < text.len() {
        fs::write(file, &text[..whole]).map_err(BlindError::file(file))?;
    }
    Ok(())
}
