//! Where the simulator is when its parameters have done what they can.

use crate::{
    diagnose::{Case, Settings, prepare},
    fit::{FitError, Horizon},
};

/// A stand-in that is wrong by more than this part of the noise is made again along the refitted run.
const WRONG: f64 = 0.1;

/// Parameters and initial states of the refitted simulator.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Refit {
    /// Parameters of the shell.
    pub theta: Vec<f64>,
    /// Initial states, log by log.
    pub starts: Vec<Vec<f64>>,
}

impl Refit {
    /// Refits a simulator, to which a stand-in lends its slopes; `None` where that foretells the refitted run well
    /// enough. A plant that is not linear is another one there, and what a stand-in misses it would blame on some
    /// effect.
    pub(super) fn of(case: &Case<'_>, settings: &Settings) -> Result<Option<Self>, FitError> {
        if settings.horizon != Horizon::FreeRun {
            return Ok(None);
        }
        let null = prepare(case, settings.horizon)?.null;
        let (mut problem, z) = (null.problem, null.minimum.z);
        let real = problem.errors(&z).ok_or(FitError::Diverged)?;
        let foretold = problem.clone().on_stand_in().errors(&z);
        let is_wrong = foretold.is_none_or(|foretold| {
            let pairs = real.iter().flatten().flatten().zip(foretold.iter().flatten().flatten());
            let differences = pairs.map(|(a, b)| (a - b).powi(2)).filter(|d| d.is_finite());
            let (n, sum) = differences.fold((0.0, 0.0), |(n, sum), d| (n + 1.0, sum + d));
            WRONG * WRONG * n < sum
        });
        let starts = (0..problem.plan().logs.len()).map(|i| problem.start_of(i, &z));
        Ok(is_wrong.then(|| Self { theta: problem.parameters(&z), starts: starts.collect() }))
    }
}
