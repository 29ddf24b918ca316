//! A candidate of which is known what it could explain.

use fd_effect::Candidate;

use super::trial::{ScoredStart, Trial};

/// A candidate with its best starts. Its simulator is made again if it is fitted: thousands of those are gigabytes, and few of
/// so many candidates are fitted.
#[derive(Debug)]
pub(super) struct Screened<'a> {
    pub candidate: &'a Candidate,
    /// Place among the candidates.
    pub index: usize,
    /// The starts and what they could explain, the best first.
    pub scored: Vec<ScoredStart>,
    /// What that has cost.
    pub simulations: usize,
}

impl<'a> Screened<'a> {
    /// What is left of a trial.
    pub(super) fn of(trial: Trial<'a>) -> Self {
        let Trial { candidate, index, scored, problem, .. } = trial;
        Self { candidate, index, scored, simulations: problem.simulations() }
    }

    /// What the best start could explain.
    pub(super) fn gain(&self) -> f64 {
        ScoredStart::gain_of(&self.scored)
    }
}
