//! A possible answer: an explanation of the logs, what it leaves, and how it forecasts.

use fd_effect::{Candidate, SiteRef};
use fd_sim::model::Model;

use super::{
    explain::explain,
    leftover::{Known, leftover},
    observe::Observed,
    prepare::KnownNoise,
    rank::Ranking,
    result::{Explanation, Leftover},
    trial::Trial,
};
use crate::{
    fit::{Minimum, Problem},
    quality::noise_floor,
    shrink::gap_per_output,
};

/// `ln(rms/floor)` from which a residual is unexplained.
const UNEXPLAINED: f64 = 0.2;

/// An explanation with what it rests on.
#[derive(Clone, Debug)]
pub(super) struct Answer {
    pub(super) explanation: Explanation,
    /// Errors in sigma.
    pub(super) errors: Vec<Vec<Vec<f64>>>,
    /// The fit, if a simulated effect is part of it.
    pub(super) fit: Option<(Problem, Minimum)>,
    /// How many effects there are in it.
    pub(super) effects: usize,
    /// Logarithm of the evidence over that of "no gap".
    pub(super) log_evidence: f64,
}

/// What is left of the gap, and how much of that may be noise.
#[derive(Clone, Debug)]
pub(super) struct Rest {
    /// Noise floor of each output, in sigma.
    pub(super) floor: Vec<f64>,
    /// Whether some output is clearly above it.
    pub(super) is_unexplained: bool,
    pub(super) leftover: Leftover,
}

impl Answer {
    /// The answer of a fit with so many effects; `None` when it diverges.
    pub(super) fn of(
        model: &Model,
        problem: &Problem,
        best: &Minimum,
        effects: usize,
        log_evidence: f64,
    ) -> Option<Self> {
        let mut problem = problem.clone();
        let explanation = explain(model, &mut problem, &best.z)?;
        let errors = problem.errors(&best.z)?;
        Some(Self {
            explanation,
            errors,
            fit: Some((problem, best.clone())),
            effects,
            log_evidence,
        })
    }

    /// The answer of the first cause; that of `refit` when it is one of the measurement, which is
    /// then among those `observed`.
    pub(super) fn first(
        causes: &Ranking,
        trials: &[Trial<'_>],
        refit: &Self,
        observed: &[(&Candidate, Observed)],
    ) -> Option<Self> {
        let (trial, cause) = causes.first()?;
        match trial {
            None => {
                let found = observed.iter().find(|(candidate, _)| cause.is_of(candidate));
                Some(match found {
                    Some((candidate, observed)) => refit.with(candidate, observed),
                    None => Self { effects: 1, log_evidence: cause.log_evidence, ..refit.clone() },
                })
            }
            Some(trial) => {
                let trial = &trials[*trial];
                Self::of(&trial.model, &trial.problem, trial.best.as_ref()?, 1, cause.log_evidence)
            }
        }
    }

    /// The same with a cause of the measurement besides, whose traces do not count as left.
    pub(super) fn with(&self, candidate: &Candidate, observed: &Observed) -> Self {
        let mut answer = Self {
            effects: self.effects + 1,
            log_evidence: self.log_evidence + observed.gain,
            ..self.clone()
        };
        if let SiteRef::Output(output, _) = &candidate.site
            && let Some(errors) = answer.errors.get_mut(*output)
        {
            errors.clone_from(&observed.left);
        }
        answer
    }

    /// What it leaves of the gap of the `refit`ted model.
    pub(super) fn rest(
        &self,
        refit: &Self,
        base: &Problem,
        noise: &KnownNoise,
        is_coloured: bool,
    ) -> Rest {
        let gap = gap_per_output(&self.errors);
        let gaps = [refit.explanation.gap.as_slice(), gap.as_slice()];
        let floor: Vec<f64> = (0..gaps[1].len())
            .map(|c| {
                let stated = noise.stated[c].map(|stated| stated / noise.sigma[c]);
                let floor = noise_floor(&self.errors[c].join(&f64::NAN), stated).unwrap_or(1.0);
                // Slow noise of the stated size is noise, whatever its innovation.
                let slow = stated.filter(|_| is_coloured).map(|stated| gaps[1][c].min(stated));
                slow.map_or(floor, |slow| floor.max(slow))
            })
            .collect();
        let is_unexplained =
            gaps[1].iter().zip(&floor).any(|(gap, f)| UNEXPLAINED < (gap / f).ln());
        let outputs = &self.explanation.outputs;
        // A controller on logged outputs has these for inputs as well, with their noise.
        let inputs = refit.explanation.model.external_inputs().len();
        let known = Known { problem: base, inputs, outputs };
        let leftover = leftover(known, &self.errors, noise, gaps, &floor);
        Rest { floor, is_unexplained, leftover }
    }
}
