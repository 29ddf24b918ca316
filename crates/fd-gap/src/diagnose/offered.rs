//! Candidates, sorted by what they act on.

use fd_effect::{Candidate, Kind, Suspects};

use super::result::NotTested;

/// What there is to try.
#[derive(Debug)]
pub(super) struct Offered {
    /// Effects on the simulation.
    pub(super) simulated: Vec<Candidate>,
    /// Effects on the distribution of a measurement.
    pub(super) observed: Vec<Candidate>,
    /// What cannot be tried.
    pub(super) refused: Vec<NotTested>,
}

impl Offered {
    pub(super) fn of(suspects: &dyn Suspects) -> Self {
        let mut offered = Self { simulated: Vec::new(), observed: Vec::new(), refused: Vec::new() };
        for offer in suspects.alone() {
            match offer {
                Ok(candidate) if candidate.kind == Kind::Simulation => {
                    offered.simulated.push(candidate);
                }
                Ok(candidate) => offered.observed.push(candidate),
                Err(refusal) => offered.refused.push(NotTested::from(&refusal)),
            }
        }
        offered
    }
}
