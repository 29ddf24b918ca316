//! A candidate of which is known what it could explain.

use fd_effect::Candidate;

use super::trial::{ScoredStart, Trial};
use crate::fit::FitError;

/// A candidate with its scored starts.
#[derive(Debug)]
pub(super) struct Screened<'a> {
    pub(super) candidate: &'a Candidate,
    /// Place among the candidates.
    pub(super) index: usize,
    /// The starts and what they could explain, the best first.
    scored: Vec<ScoredStart>,
    /// With its simulator. Thousands of those are gigabytes, and few of so many candidates are fitted.
    trial: Option<Trial<'a>>,
}

impl<'a> Screened<'a> {
    /// What is left of a trial: of one among many only what it could explain.
    pub(super) fn of(mut trial: Trial<'a>, is_of_many: bool) -> Self {
        let (candidate, index) = (trial.candidate, trial.index);
        let scored = std::mem::take(&mut trial.scored);
        Self { candidate, index, scored, trial: (!is_of_many).then_some(trial) }
    }

    /// What the best start could explain.
    pub(super) fn gain(&self) -> f64 {
        ScoredStart::gain_of(&self.scored)
    }

    /// The trial again, which is made anew if it was not kept.
    pub(super) fn trial(
        self,
        anew: impl Fn(&'a Candidate) -> Result<Trial<'a>, FitError>,
    ) -> Result<Trial<'a>, FitError> {
        let trial = self.trial.map_or_else(|| anew(self.candidate), Ok)?;
        Ok(Trial { scored: self.scored, ..trial })
    }
}
