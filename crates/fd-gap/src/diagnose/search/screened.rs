//! A candidate of which is known what it could explain.

use std::collections::HashMap;

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

/// What the best law of the cause of each candidate promises, since laws are started from one another; and what all causes
/// promise, the most first.
pub(super) fn of_causes<'c>(
    promises: impl Iterator<Item = (&'c Candidate, f64)>,
) -> (Vec<f64>, Vec<f64>) {
    let (candidates, promises): (Vec<&Candidate>, Vec<f64>) = promises.unzip();
    let mut best = HashMap::new();
    for (candidate, promise) in candidates.iter().zip(promises) {
        let known = best.entry(candidate.identity()).or_insert(0.0_f64);
        *known = known.max(promise);
    }
    let each = candidates.iter().map(|candidate| best[&candidate.identity()]).collect();
    let mut ranked: Vec<f64> = best.into_values().collect();
    ranked.sort_by(|a, b| b.total_cmp(a));
    (each, ranked)
}
