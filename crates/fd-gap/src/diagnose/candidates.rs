//! All candidates, sorted by where they act.

use fd_effect::{Candidate, Kind, Suspects};

use super::{
    case::Case,
    result::{Cause, NotTested},
};

/// The family of free curves, which follow a misfit without being a law of anything.
const FREE_CURVES: &str = "map";

/// The law of those of time.
const OF_TIME: &str = "of-time";

/// A parameter that wanders follows a misfit as freely.
const WANDERS: &str = "parameter-wander";

/// All single suspects of a case.
#[derive(Debug)]
pub(super) struct Candidates {
    /// Effects on the simulation.
    pub simulated: Vec<Candidate>,
    /// Effects on the distribution of a measurement, which leave the simulation as it is.
    pub measured: Vec<Candidate>,
    /// What cannot be tried.
    pub refused: Vec<NotTested>,
}

impl Candidates {
    pub(super) fn of(suspects: &dyn Suspects) -> Self {
        let mut sorted = Self { simulated: Vec::new(), measured: Vec::new(), refused: Vec::new() };
        for suspect in suspects.alone() {
            match suspect {
                Ok(candidate) if candidate.kind == Kind::Simulation => {
                    sorted.simulated.push(candidate);
                }
                Ok(candidate) => sorted.measured.push(candidate),
                Err(refusal) => sorted.refused.push(NotTested::from(&refusal)),
            }
        }
        sorted
    }
}

/// Whether both are laws of one cause.
pub(super) fn is_same_cause(a: &Candidate, b: &Candidate) -> bool {
    a.identity() == b.identity()
}

/// Whether it is a free curve.
pub(super) fn is_free_curve(candidate: &Candidate) -> bool {
    candidate.family == FREE_CURVES
}

/// Whether it is a free curve of a signal, which holds for another log as well, and not of time.
pub(crate) fn is_curve_of_signal(candidate: &Candidate) -> bool {
    is_free_curve(candidate) && candidate.law != OF_TIME
}

/// Whether it follows one log as it pleases: a free curve, or a parameter that wanders.
pub(crate) fn follows_anything(candidate: &Candidate) -> bool {
    is_free_curve(candidate) || wanders(candidate.label)
}

/// Whether a cause is one of the suspects, and a law: nothing that follows one log as it pleases.
pub(crate) fn is_law(case: &Case<'_>, cause: &Cause) -> bool {
    let is_it = |c: &Candidate| c.identity() == cause.identity() && c.law == cause.law;
    let own = case.suspects.alone().into_iter().flatten().find(is_it);
    own.is_some_and(|own| own.kind == Kind::Simulation && !follows_anything(&own))
}

/// Whether effects of this label are parameters that wander.
pub(crate) fn wanders(label: &str) -> bool {
    label == WANDERS
}
